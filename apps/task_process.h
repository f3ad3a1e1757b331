// Tasks in Python for a program that is not Python: a process of their own, which shares rows of
// columns with this one.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace engram::apps {

// Registers the tasks of a Python file, for the life of this process. Their rules run in processes
// below this one, one for each batch. Throws Error: kUnavailable if there is no Python with the
// package; kTaskFailed, with Python's message, if the file fails.
void load_python_tasks(const std::string& file);

}  // namespace engram::apps
