// Processes that commands of tests start, watched from outside.
#pragma once

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "tests/temporary_folder.h"

namespace engram::test {

// A zombie does not run.
inline bool runs(const std::string& process) {
  std::ifstream file("/proc/" + process + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t end = text.rfind(')');
  return end != std::string::npos && text.compare(end, 4, ") Z ") != 0;
}

// A signal takes a moment to arrive.
inline bool ends_soon(const std::string& process) {
  for (int i = 0; i < 300 && runs(process); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return !runs(process);
}

// The number that a command writes into a file, which takes it a moment.
inline std::string number_in(const std::filesystem::path& file) {
  std::string text = test::read_file(file);
  for (int i = 0; i < 500 && !text.ends_with('\n'); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    text = test::read_file(file);
  }
  REQUIRE(text.ends_with('\n'));
  text.pop_back();
  return text;
}

}  // namespace engram::test
