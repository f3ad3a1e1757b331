// A library that is none of tasks.
extern "C" __attribute__((visibility("default"))) int engram_something_else() { return 1; }
