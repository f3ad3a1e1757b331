// What the environment and the parents of this process say of a launcher such as mpirun.
#pragma once

#include <span>
#include <string>

namespace engram {

// What a launcher's variables say.
struct Launch {
  int processes = 1;
  std::string variable;  // the one that says so, with its value; empty: none
};

// Reads this process's environment, which launchers also leave to programs that their own start.
Launch launch_of_environment();

// A process between this one and the first of the system.
struct Ancestor {
  std::string name;
  bool same_group = false;  // as its child: no shell with job control has started that
};

// True if a launcher, or a script of its, has started the process with these ancestors, nearest
// first. Interactive shells and other programs that a launcher has started do not count.
bool is_launched(std::span<const Ancestor> ancestors);
// For this process. parent: set to the name of the process that has started it.
bool is_launched(std::string& parent);

}  // namespace engram
