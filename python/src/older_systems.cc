// Wheels are built on Debian 12 and run on systems as old as glibc 2.34 and GCC 11's C++ library,
// which libmujoco needs. These functions replace those of newer systems; cmake/EngramWheel.cmake
// makes the linker redirect callers of the wrapped ones to them.
#include <pthread.h>
#include <sys/random.h>

#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstdlib>
#include <mutex>

extern "C" {

// In glibc 2.35 hypot has a new version; Debian's libcairo.a calls it.
#if defined(__aarch64__)
__asm__(".symver hypot_of_any_glibc, hypot@GLIBC_2.17");
#else
__asm__(".symver hypot_of_any_glibc, hypot@GLIBC_2.2.5");
#endif
double hypot_of_any_glibc(double x, double y);
double __wrap_hypot(double x, double y) { return hypot_of_any_glibc(x, y); }

// New in glibc 2.36; Debian's libexpat.a shuffles its hash tables with it.
void arc4random_buf(void* buffer, std::size_t size) noexcept {
  auto* at = static_cast<unsigned char*>(buffer);
  while (size > 0) {
    const ssize_t got = getrandom(at, size, 0);
    if (got < 0 && errno != EINTR) std::abort();
    if (got <= 0) continue;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
}

// std::condition_variable::wait has a new version in GCC 12's library.
void __wrap__ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE(
    std::condition_variable* self, std::unique_lock<std::mutex>& lock) {
  pthread_cond_wait(self->native_handle(), lock.mutex()->native_handle());
}
}
