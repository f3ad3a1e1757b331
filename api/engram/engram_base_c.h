/** @file
 * engram: status codes, messages, version, texts. A part of the C API; include engram_c.h. */
#ifndef ENGRAM_ENGRAM_BASE_C_H
#define ENGRAM_ENGRAM_BASE_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>

#if defined(ENGRAM_STATIC)
#define ENGRAM_API
#else
#define ENGRAM_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum engram_status {
  ENGRAM_OK = 0,
  ENGRAM_INVALID_ARGUMENT = 1, /**< a value outside what is allowed, or of the wrong shape */
  ENGRAM_UNKNOWN_ID = 2,       /**< no task, option or field of that name */
  ENGRAM_UNAVAILABLE = 3,      /**< the machine lacks it: threads, memory, a device */
  ENGRAM_BAD_STATE = 4,        /**< not allowed at this point */
  ENGRAM_IO = 5,               /**< a file could not be read or written */
  ENGRAM_INTERNAL = 6,         /**< a defect of the library itself */
  ENGRAM_TASK_FAILED = 7       /**< the code of a user's task has failed */
} engram_status;

/** The message of this thread's last failing call; "" if there was none. Valid until this thread's
 * next failing call. Never NULL. */
ENGRAM_API const char* engram_last_error(void);

/** Version of the library, "0.6.0". */
ENGRAM_API const char* engram_version(void);

/** Frees a text that a function of this API has set; NULL is allowed. */
ENGRAM_API void engram_free_text(char* text);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
