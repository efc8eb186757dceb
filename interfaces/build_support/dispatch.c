// Copyright 2026 armsim_ros authors
// SPDX-License-Identifier: Apache-2.0

// Find a type support in the library that this file is linked into.
//
// rosidl_typesupport_c looks for an implementation in a library of its own,
// lib<package>__<implementation>.so. Here all implementations of a package share one library with
// its Python module, so its two handle functions are renamed to these when a package is compiled.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <string.h>

#include "rosidl_runtime_c/message_type_support_struct.h"
#include "rosidl_runtime_c/service_type_support_struct.h"
#include "rosidl_typesupport_c/identifier.h"
#include "rosidl_typesupport_c/type_support_map.h"

// glibc 2.34 moved these functions from libdl to libc and gave them a new version; the first one
// exists in every glibc, so that the library loads where it is older than on this machine.
#if defined(__GLIBC__) && defined(__x86_64__)
#define FIRST_VERSION "GLIBC_2.2.5"
#elif defined(__GLIBC__) && defined(__aarch64__)
#define FIRST_VERSION "GLIBC_2.17"
#endif
#ifdef FIRST_VERSION
__asm__(".symver dladdr, dladdr@" FIRST_VERSION);
__asm__(".symver dlclose, dlclose@" FIRST_VERSION);
__asm__(".symver dlopen, dlopen@" FIRST_VERSION);
__asm__(".symver dlsym, dlsym@" FIRST_VERSION);
#endif

#define HIDDEN __attribute__((visibility("hidden")))

HIDDEN const rosidl_message_type_support_t * armsim_message_typesupport(
  const rosidl_message_type_support_t * handle, const char * identifier);

HIDDEN const rosidl_service_type_support_t * armsim_service_typesupport(
  const rosidl_service_type_support_t * handle, const char * identifier);

// Return the function of this library that hands out the wanted implementation, or NULL.
static void * find(const type_support_map_t * map, const char * identifier)
{
  for (size_t i = 0; i < map->size; ++i) {
    if (strcmp(map->typesupport_identifier[i], identifier) != 0) {
      continue;
    }
    if (!map->data[i]) {
      Dl_info here;
      if (!dladdr((const void *)&find, &here)) {
        return NULL;
      }
      void * library = dlopen(here.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
      if (!library) {
        return NULL;
      }
      map->data[i] = dlsym(library, map->symbol_name[i]);
      dlclose(library);  // the module itself keeps the library open
    }
    return map->data[i];
  }
  return NULL;
}

const rosidl_message_type_support_t * armsim_message_typesupport(
  const rosidl_message_type_support_t * handle, const char * identifier)
{
  if (strcmp(handle->typesupport_identifier, identifier) == 0) {
    return handle;
  }
  const rosidl_message_type_support_t * (*get)(void) =
    (const rosidl_message_type_support_t * (*)(void))find(handle->data, identifier);
  return get ? get() : NULL;
}

const rosidl_service_type_support_t * armsim_service_typesupport(
  const rosidl_service_type_support_t * handle, const char * identifier)
{
  if (strcmp(handle->typesupport_identifier, identifier) == 0) {
    return handle;
  }
  const rosidl_service_type_support_t * (*get)(void) =
    (const rosidl_service_type_support_t * (*)(void))find(handle->data, identifier);
  return get ? get() : NULL;
}
