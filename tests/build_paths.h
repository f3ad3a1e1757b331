// Where the build has put what tests use. In one object, so that no other one differs from build
// folder to build folder.
#pragma once

namespace engram::test {

extern const char* const kRoot;                      // the sources
extern const char* const kData;                      // tests/data
extern const char* const kTaskLibraries;             // folder of libraries of tasks
extern const char* const kCommand;                   // the engram command; "" where it is not built
extern const char* const kNondeterministicContacts;  // a library to preload; "" likewise

}  // namespace engram::test
