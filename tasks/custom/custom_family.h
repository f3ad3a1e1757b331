// Families of custom tasks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tasks/custom/instance.h"

namespace engram::tasks {

// What is known of a task before an instance is made.
struct CustomDefinition {
  std::string id;
  std::string family;
  int horizon = 0;  // control steps
  std::string instruction;
  std::string memory_type;
  double oracle_floor = 0.95;
  std::vector<CustomConstant> constants;
  std::string content = {};  // SHA-256 of what defines it; "": results do not name it
};

// Registers the task for the life of the process, with which the factory lives on; the same id of
// the same family again takes the place of the earlier one. Makes one instance, to see that it
// works. Throws Error: kInvalidArgument if the definition cannot be used; and what the factory
// throws.
void register_custom(CustomDefinition definition, std::shared_ptr<const CustomFactory> factory);

}  // namespace engram::tasks
