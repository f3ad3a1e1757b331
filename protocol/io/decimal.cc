#include "protocol/io/decimal.h"

#include <cstdio>

namespace engram {

std::string decimal(double value, int digits) {
  char text[400];  // the largest double has 309 digits before the point
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

}  // namespace engram
