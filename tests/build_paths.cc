#include "tests/build_paths.h"

namespace engram::test {

const char* const kRoot = ENGRAM_ROOT;
const char* const kData = ENGRAM_ROOT "/tests/data";
const char* const kTaskLibraries = ENGRAM_TASK_LIBRARIES;
const char* const kCommand = ENGRAM_CLI;
const char* const kNondeterministicContacts = ENGRAM_NONDETERMINISTIC_CONTACTS;

}  // namespace engram::test
