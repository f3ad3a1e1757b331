// Parts of engram that are loaded when they are needed, for the sake of the libraries they need.
#pragma once

namespace engram {

// A function of the shared object of that name: the one beside the program, as in a build folder,
// where installations have it, or anywhere on the system's search path. Null if there is none, and
// ::dlerror() says why.
void* module_function(const char* module, const char* function);

}  // namespace engram
