// The 97 tasks of the benchmark as published, apart from what the registry says of them.
#pragma once

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/build_paths.h"

namespace engram::test {

// id, family, horizon, split, memory type, canonical, instruction.
using BenchmarkRow = std::vector<std::string>;

// registry.csv: semicolons between fields, no quoting; without its first line, the names.
inline const std::vector<BenchmarkRow>& benchmark() {
  static const std::vector<BenchmarkRow> table = [] {
    std::ifstream file(std::string(kData) + "/registry.csv");
    std::vector<BenchmarkRow> rows;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::istringstream fields(line);
      BenchmarkRow row;
      for (std::string field; std::getline(fields, field, ';');) row.push_back(field);
      rows.push_back(row);
    }
    return rows;
  }();
  return table;
}

// Whether the benchmark has a task of that id. Others are users' own.
inline bool is_benchmark_id(std::string_view id) {
  return std::ranges::any_of(benchmark(), [id](const BenchmarkRow& row) { return row[0] == id; });
}

}  // namespace engram::test
