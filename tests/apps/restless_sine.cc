// For a program to be wrong with: preloaded, every thousandth sine is one bit off, so that results
// depend on the order of the work.
#include <dlfcn.h>

#include <atomic>
#include <cmath>

extern "C" void sincos(double angle, double* sine, double* cosine) noexcept {
  static const auto exact =
      reinterpret_cast<void (*)(double, double*, double*)>(dlsym(RTLD_NEXT, "sincos"));
  static std::atomic<int> calls = 0;
  exact(angle, sine, cosine);
  if (calls.fetch_add(1, std::memory_order_relaxed) % 1000 == 999) {
    *sine = std::nextafter(*sine, 2.0);
  }
}
