// Runs the built `engram` command, as a user would.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "protocol/io/json_checksum.h"
#include "tests/build_paths.h"
#include "tests/temporary_folder.h"

namespace engram::test {

using ParsedJson = nlohmann::ordered_json;

struct CommandResult {
  int code = -1;  // exit code; -1 if a signal ended the program
  std::string out;
  std::string err;

  // Standard output, which must be one JSON document.
  ParsedJson json() const {
    INFO(err);
    REQUIRE(code == 0);
    return ParsedJson::parse(out);
  }
};

// Runs `engram` with these arguments, as the shell splits them. `redirect` may send standard output
// elsewhere, `environment` set variables.
inline CommandResult engram_command(const std::string& arguments, const std::string& redirect = "",
                                    const std::string& environment = "") {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  const std::string err = (folder.path() / "err").string();
  const std::string line = environment + " '" + test::kCommand + "' " + arguments +
                           " </dev/null >'" + out + "' 2>'" + err + "' " + redirect;
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out), read_file(err)};
}

// Whether `mpirun engram` shares work here.
inline bool has_mpi() {
  return std::system("command -v mpirun >/dev/null") == 0 &&
         std::filesystem::exists(std::filesystem::path(test::kCommand).parent_path() /
                                 "libengram_mpi.so");
}

// Runs `engram` as N processes under mpirun.
inline CommandResult command_of_ranks(int count, const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  // The MPI library keeps some memory until the process ends.
  const std::string line =
      "ASAN_OPTIONS=\"$ASAN_OPTIONS:detect_leaks=0\" OMPI_ALLOW_RUN_AS_ROOT=1 "
      "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 300 mpirun --oversubscribe -n " +
      std::to_string(count) + " '" + test::kCommand + "' " + arguments + " </dev/null >'" + out +
      "' 2>'" + out + ".err'";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out), read_file(out + ".err")};
}

// Checks that the command refuses: exit code, nothing on standard output, one line with `words` on
// standard error.
inline void require_refusal(const std::string& arguments, int code, const std::string& words) {
  const CommandResult result = engram_command(arguments);
  INFO(arguments << ": " << result.err);
  CHECK(result.code == code);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.err.starts_with("engram: "));
  CHECK_THAT(result.err, Catch::Contains(words));
}

// The example of a policy in a process of its own, as a command.
inline std::string pipe_policy() {
  return "python3 " +
         (std::filesystem::path(test::kRoot) / "python" / "examples" / "pipe_policy.py").string();
}

// The example of one that names answers.
inline std::string choices_policy() {
  return "python3 " +
         (std::filesystem::path(test::kRoot) / "python" / "examples" / "choices_policy.py")
             .string();
}

// The text of an edited document of engram's, as a user writes it who knows the checksum.
inline std::string with_checksum(ParsedJson edited) {
  edited.erase("checksum");
  JsonTable document = table(parse_json(edited.dump()).value());
  add_checksum(document);
  return to_text(document);
}

inline std::vector<std::string> keys_of(const ParsedJson& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

}  // namespace engram::test
