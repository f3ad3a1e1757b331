#define CATCH_CONFIG_MAIN  // NOLINT(readability-identifier-naming)
#include <catch2/catch.hpp>
