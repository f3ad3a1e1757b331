#include <engram/engram.h>

#include <iostream>

int main() {
  try {
    auto batch = engram::make("RememberColor3-VLA-v0", {.num_envs = 16, .seed = 1});
    std::vector<float> actions = batch.make_actions();
    batch.reset();
    for (int i = 0; i < batch.horizon(); ++i) {
      batch.act(engram::Policy::kOracle, actions);
      batch.step(actions);
    }
    int successes = 0;
    for (const std::uint8_t success : batch.success_once()) successes += success;
    std::cout << "C++: engram " << engram::version() << ", " << successes << " of "
              << batch.num_envs() << " succeed\n";
    return successes >= 15 ? 0 : 1;
  } catch (const engram::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
