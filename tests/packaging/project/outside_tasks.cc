// Plays a task out of a library: outside_tasks LIBRARY ID.
#include <engram/engram.h>

#include <iostream>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    engram::load_tasks(argv[1]);
    auto batch = engram::make(argv[2], {.num_envs = 32, .seed = 1});
    std::vector<float> actions = batch.make_actions();
    batch.reset();
    for (int i = 1; i < batch.horizon(); ++i) {
      batch.act(engram::Policy::kOracle, actions);
      batch.step(actions);
    }
    int successes = 0;
    for (const std::uint8_t success : batch.success_once()) successes += success;
    std::cout << argv[2] << ": " << successes << " of " << batch.num_envs() << " succeed\n";
    return successes == batch.num_envs() ? 0 : 1;
  } catch (const engram::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
