// Gain of a policy that works on one half of the batch while the other half is stepped:
//
//   half_batches [HIDDEN [ROUNDS]]
//
// The policy is a network of two hidden layers of that many units with random weights, evaluated in
// the calling thread. Rounds of both ways are interleaved; what is printed are medians.
#include <engram/engram.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace {

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr const char* kId = "RememberColor9-VLA-v0";
constexpr int kEnvs = 256;
constexpr int kSteps = 30;  // of a round

class Network {
 public:
  Network(int inputs, int hidden, int outputs)
      : first_(0.3F * RowMatrix::Random(inputs, hidden)),
        second_(0.1F * RowMatrix::Random(hidden, hidden)),
        third_(0.1F * RowMatrix::Random(hidden, outputs)) {}

  void act(const engram::VectorEnv& env, std::vector<float>& actions) const {
    const Eigen::Map<const RowMatrix> seen(env.observation().data(), env.num_envs(),
                                           env.state_dim());
    const RowMatrix hidden = (seen * first_).array().tanh();
    const RowMatrix deeper = (hidden * second_).array().tanh();
    Eigen::Map<RowMatrix>(actions.data(), env.num_envs(), env.action_dim()) =
        (deeper * third_).array().tanh();
  }

 private:
  RowMatrix first_;
  RowMatrix second_;
  RowMatrix third_;
};

// Environment steps per second of kSteps calls of f, each of which steps kEnvs environments.
template <class F>
double rate(F&& f) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) f();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  return kSteps * kEnvs / seconds.count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare(int hidden, int rounds) {
  engram::VectorEnv whole = engram::make(kId, {.num_envs = kEnvs});
  std::array<engram::VectorEnv, 2> halves = {
      engram::make(kId, {.num_envs = kEnvs / 2, .seed = 0}),
      engram::make(kId, {.num_envs = kEnvs / 2, .seed = kEnvs / 2})};
  const Network network(whole.state_dim(), hidden, whole.action_dim());
  std::vector<float> actions = whole.make_actions();
  std::array<std::vector<float>, 2> half_actions = {halves[0].make_actions(),
                                                    halves[1].make_actions()};
  whole.reset();
  for (engram::VectorEnv& half : halves) half.reset();
  network.act(halves[0], half_actions[0]);
  halves[0].step_async(half_actions[0]);

  std::vector<double> thinking;
  std::vector<double> stepping;
  std::vector<double> in_turn;
  std::vector<double> overlapped;
  for (int round = 0; round < rounds; ++round) {
    // The half under way must not take part in the other measurements.
    halves[0].step_wait();
    thinking.push_back(rate([&] { network.act(whole, actions); }));
    stepping.push_back(rate([&] { whole.step(actions); }));
    in_turn.push_back(rate([&] {
      network.act(whole, actions);
      whole.step(actions);
    }));
    halves[0].step_async(half_actions[0]);
    overlapped.push_back(rate([&] {
      for (const std::size_t next : {1U, 0U}) {
        network.act(halves[next], half_actions[next]);  // while the other half moves
        halves[1 - next].step_wait();
        halves[next].step_async(half_actions[next]);
      }
    }));
  }
  std::printf("policy alone     %9.0f environment steps/s\n", median(thinking));
  std::printf("simulator alone  %9.0f\n", median(stepping));
  std::printf("in turn          %9.0f\n", median(in_turn));
  std::printf("two halves       %9.0f\n", median(overlapped));
}

}  // namespace

int main(int argc, char** argv) {
  const int hidden = argc > 1 ? std::atoi(argv[1]) : 512;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 9;
  if (hidden < 1 || rounds < 1) {
    std::fprintf(stderr, "usage: half_batches [HIDDEN, at least 1 [ROUNDS, at least 1]]\n");
    return 2;
  }
  try {
    compare(hidden, rounds);
  } catch (const engram::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
