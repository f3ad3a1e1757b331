// The values of constants that have been tried: least, middle and greatest sensible ones. Listed in
// tests/data/variants, one file per room of tasks; docs/data/tried_values.csv shows them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "protocol/make/variants.h"
#include "tests/build_paths.h"

namespace engram::test {

// id;constants as JSON;least success of the oracle;why less than 0.95
struct TriedVariant {
  std::string id;
  std::string json;
  double oracle_floor = 0.95;
  std::string note = {};

  ConstantTable constants() const { return parse_constants(json); }
};

inline std::vector<TriedVariant> tried_variants() {
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(std::string(kData) + "/variants")) {
    files.push_back(file.path());
  }
  std::ranges::sort(files);
  std::vector<TriedVariant> variants;
  for (const auto& path : files) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      if (line.empty() || line.starts_with('#')) continue;
      std::istringstream fields(line);
      TriedVariant variant;
      std::string floor;
      std::getline(fields, variant.id, ';');
      std::getline(fields, variant.json, ';');
      std::getline(fields, floor, ';');
      std::getline(fields, variant.note, ';');
      variant.oracle_floor = std::stod(floor);
      variants.push_back(std::move(variant));
    }
  }
  return variants;
}

}  // namespace engram::test
