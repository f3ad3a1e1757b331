#include "tests/thread_failure.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>

namespace {

std::atomic<int> until_failure = 0;  // 0: none will fail

}  // namespace

// Stands in front of the C library's, or of a sanitizer's: that one is another library, or else a
// part of this program under the name of
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" int __interceptor_pthread_create(pthread_t*, const pthread_attr_t*, void* (*)(void*),
                                            void*) noexcept __attribute__((weak));

// NOLINTNEXTLINE(readability-identifier-naming): the name is POSIX's
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) noexcept {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const Create create = __interceptor_pthread_create != nullptr
                                   ? __interceptor_pthread_create
                                   : reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
  if (until_failure.load() > 0 && until_failure.fetch_sub(1) == 1) return EAGAIN;
  return create(thread, attributes, start, argument);
}

namespace engram::test {

FailingThread::FailingThread(int number) noexcept { until_failure = number; }
FailingThread::~FailingThread() { until_failure = 0; }

}  // namespace engram::test
