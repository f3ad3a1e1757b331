// Policies as processes: their end, and the messages they may send.
#include "protocol/eval/policies/policy_process.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <future>
#include <stdexcept>
#include <thread>
#include <utility>

#include "protocol/eval/policies/choice_question.h"
#include "tests/protocol/eval/policies/watched_process.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

// A context that nobody stops, in a program that survives the end of a policy.
struct Work {
  Work() { std::signal(SIGPIPE, SIG_IGN); }

  std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  WorkContext context{0, stopped, steps};
};

PolicyProcessOptions options_of(const std::string& command) {
  PolicyProcessOptions options;
  options.command = command;
  options.timeout = std::chrono::seconds(100);  // longer than any of these tests takes
  return options;
}

TEST_CASE("A shell that dies is reported at once, with all its processes gone", "[policy]") {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "child").string();
  const Work work;
  // The child has the pipe, which therefore does not close.
  for (const char* end : {"exit 3", "kill -9 $$"}) {
    std::filesystem::remove(file);
    const std::string command = "sleep 1000 & echo $! >'" + file + "'; " + end;
    CHECK_THROWS_WITH(
        PolicyProcess(options_of(command), work.context),
        Catch::Contains(end == std::string("exit 3") ? "ended with exit code 3" : "by signal 9"));
    CHECK(test::ends_soon(test::number_in(file)));
  }
}

TEST_CASE("A policy that is no longer waited for ends with all its processes", "[policy]") {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "child").string();
  const Work work;
  PolicyProcessOptions options =
      options_of("trap '' TERM HUP; sleep 1000 & echo $! >'" + file + "'; sleep 1000");
  options.timeout = std::chrono::seconds(3);  // by then the shell has written the number
  CHECK_THROWS_WITH(PolicyProcess(options, work.context), Catch::Contains("within 3 s"));
  CHECK(test::ends_soon(test::number_in(file)));
}

TEST_CASE("A message before the end of a policy is read", "[policy]") {
  const Work work;
  // The answer to the greeting, in octal; then nothing more.
  const std::string greeting =
      R"(printf '\1\0\0\0\10\0\0\0ENGM\1\0\0\0'; head -c 44 >/dev/null; exit 0)";
  CHECK_NOTHROW(PolicyProcess(options_of(greeting), work.context));
}

// --- time ---

using Clock = std::chrono::steady_clock;

PolicyProcessOptions limited(const std::string& command) {
  PolicyProcessOptions options = options_of(command);
  options.timeout = std::chrono::seconds(1);
  return options;
}

TEST_CASE("An answer that drips is late as a whole", "[policy]") {
  const Work work;
  const auto start = Clock::now();
  CHECK_THROWS_WITH(PolicyProcess(limited("printf '\\1\\0\\0\\0\\377\\0\\0\\0';"
                                          "while printf x; do sleep 0.05; done"),
                                  work.context),
                    Catch::Contains("within 1 s"));
  CHECK(Clock::now() - start < std::chrono::seconds(8));
}

TEST_CASE("A failure of any length is reported by its beginning, without control characters",
          "[policy]") {
  const Work work;
  const auto start = Clock::now();
  std::string message;
  try {
    // 200 MB are announced, and are never sent as a whole.
    PolicyProcess(options_of("printf '\\5\\0\\0\\0\\0\\302\\353\\13\\233[31m\\342\\200\\256';"
                             "while printf 'no such file '; do :; done"),
                  work.context);
  } catch (const Error& error) {
    message = error.what();
  }
  CHECK(Clock::now() - start < std::chrono::seconds(20));
  CHECK_THAT(message, Catch::Contains("says: \\x9b[31m\\u202eno such file no such file"));
  CHECK_THAT(message, Catch::EndsWith("..."));
  CHECK(message.size() < 2500);
}

// --- answers ---

// The other end of the pipes, in the same thread.
class Pipes {
 public:
  Pipes() {
    REQUIRE(::pipe2(to_.data(), O_CLOEXEC) == 0);
    REQUIRE(::pipe2(from_.data(), O_CLOEXEC) == 0);
    say({1, 8, 0x4d474e45, 1});
  }
  ~Pipes() {
    ::close(to_[0]);
    ::close(from_[1]);
  }
  Pipes(const Pipes&) = delete;
  Pipes& operator=(const Pipes&) = delete;

  int to() const { return to_[1]; }
  int from() const { return from_[0]; }
  void say(const std::vector<std::uint32_t>& words) const {
    write(words.data(), words.size() * sizeof(std::uint32_t));
  }
  // A message in which the policy tells of itself.
  void tell(const std::string& text) const {
    say({9, static_cast<std::uint32_t>(text.size())});
    write(text.data(), text.size());
  }
  // An action of zeros for one episode.
  void answer() const { say({4, 4 * 10, 1, 1, 7, 0, 0, 0, 0, 0, 0, 0}); }
  // Everything that waits to be read.
  std::vector<char> received() const {
    std::vector<char> all;
    std::array<char, 1024> bytes{};
    pollfd one{to_[0], POLLIN, 0};
    while (::poll(&one, 1, 0) > 0) {
      const ssize_t count = ::read(to_[0], bytes.data(), bytes.size());
      if (count <= 0) break;
      all.insert(all.end(), bytes.begin(), bytes.begin() + count);
    }
    return all;
  }
  // Makes room for a page of the next question.
  void read_page() const {
    std::array<char, 4096> bytes{};
    pollfd one{to_[0], POLLIN, 0};
    if (::poll(&one, 1, 0) > 0) (void)!::read(to_[0], bytes.data(), bytes.size());
  }
  // Calls it once there is a question, on a thread of its own.
  std::future<void> when_asked(std::function<void()> act) const {
    while (drain()) {
    }
    return std::async(std::launch::async, [this, act = std::move(act)] {
      pollfd one{to_[0], POLLIN, 0};
      ::poll(&one, 1, 10'000);
      act();
    });
  }
  std::future<void> answer_when_asked(int times) const {
    return when_asked([this, times] {
      for (int i = 0; i < times; ++i) answer();
    });
  }

 private:
  bool drain() const {
    std::array<char, 1024> bytes{};
    pollfd one{to_[0], POLLIN, 0};
    return ::poll(&one, 1, 0) > 0 && ::read(to_[0], bytes.data(), bytes.size()) > 0;
  }

  void write(const void* bytes, std::size_t size) const {
    // Catch's assertions are for the main thread.
    if (::write(from_[1], bytes, size) != static_cast<ssize_t>(size)) {
      throw std::runtime_error("the pipe takes no answer");
    }
  }

  std::array<int, 2> to_{};
  std::array<int, 2> from_{};
};

struct Question {
  std::vector<std::int32_t> env = {0};
  std::vector<std::int32_t> episode = {7};
  std::vector<std::int32_t> step = {0};
  std::vector<std::uint8_t> first = {1};
  std::vector<std::string> instruction = {"touch it"};
  std::vector<float> proprio = std::vector<float>(7);

  void ask(PolicyProcess& policy, const WorkContext& context) {
    PolicyRequest request;
    request.env_id = "RememberColor3-VLA-v0";
    request.count = 1;
    request.slots = env;
    request.episodes = request.numbers = episode;
    request.steps = step;
    request.first = first;
    request.instructions = instruction;
    request.proprio = proprio;
    request.context = &context;
    PolicyReply reply(1, 7);
    policy.act(request, reply);
    CHECK(reply.chunk(0).size() == 7);
    ++step[0];
  }
};

// --- choices ---

struct ChoiceCall {
  const std::vector<std::int32_t> steps = {0, 5};
  const std::vector<float> proprio = std::vector<float>(14, 0.5F);
  const std::vector<std::string> texts = {"a", "bc"};
  ChoiceQuestion question;

  explicit ChoiceCall(const WorkContext& context) {
    question.env_id = "RememberColor3-VLA-v0";
    question.slot = 2;
    question.episode = 3;
    question.number = 77;
    question.step = 5;
    question.instruction = "touch it";
    question.form.question = "Which?";
    question.choices = {"the red cube", "the blue cube"};
    question.steps = steps;
    question.proprio = proprio;
    question.texts = texts;
    question.context = &context;
  }

  std::vector<int> ask(PolicyProcess& policy) const {
    ChoiceAnswer answer(question);
    policy.choose(question, answer);
    return {answer.indices().begin(), answer.indices().end()};
  }
};

constexpr std::uint32_t kDigits = 0x31303030;  // "0001" as it lies in memory

TEST_CASE("A question over pipes is as documented", "[policy][choices]") {
  const Pipes pipes;
  const Work work;
  PolicyProcessOptions options = options_of("x");
  options.choices = true;
  PolicyProcess policy(pipes.to(), pipes.from(), options, work.context);
  const std::vector<char> greeting = pipes.received();
  ByteReader hello(std::as_bytes(std::span(greeting)));
  (void)hello.take(8 + 7 * 4);
  CHECK(hello.get<std::uint32_t>() == 0);  // size of an action

  std::future<void> other = pipes.when_asked([&] { pipes.say({7, 12, 1, 4, kDigits}); });
  CHECK(ChoiceCall(work.context).ask(policy) == std::vector<int>{1});
  other.get();
  const std::vector<char> bytes = pipes.received();
  ByteReader in(std::as_bytes(std::span(bytes)));
  CHECK(in.get<std::uint32_t>() == 2);  // the task
  (void)in.take(in.get<std::uint32_t>());
  CHECK(in.get<std::uint32_t>() == 6);
  const auto size = in.get<std::uint32_t>();
  CHECK(size == in.rest().size());
  CHECK(in.values<std::int32_t>(4) == std::vector<std::int32_t>{2, 77, 5, 0});
  CHECK(in.text() == "touch it");
  CHECK(in.text() == "Which?");
  CHECK(in.values<std::uint32_t>(4) == std::vector<std::uint32_t>{1, 1, 0, 2});
  CHECK(in.text() == "the red cube");
  CHECK(in.text() == "the blue cube");
  CHECK(in.get<std::uint32_t>() == 2);
  CHECK(in.values<std::int32_t>(2) == std::vector<std::int32_t>{0, 5});
  CHECK(in.values<float>(14) == std::vector<float>(14, 0.5F));
  CHECK(in.text() == "a");
  CHECK(in.text() == "bc");
  CHECK(in.rest().empty());
}

TEST_CASE("Answers that are no choices end a policy", "[policy][choices]") {
  const Work work;
  const std::pair<std::vector<std::uint32_t>, const char*> answers[] = {
      {{7, 4, 0}, "0 choices given, 1 needed"},
      {{7, 4, 4'000'000'000}, "4000000000 choices given, at most 1 allowed"},
      {{7, 8, 1, 9}, "message too short"},
      {{7, 16, 1, 4, kDigits, 0}, "answered with bytes to spare"},
      {{4, 4, 1}, "answered with message type 4 of 4 bytes, type 7 expected"},
      {{5, 4, kDigits}, "says: 0001"}};
  for (const auto& [answer, words] : answers) {
    const Pipes pipes;
    PolicyProcessOptions options = options_of("x");
    options.choices = true;
    PolicyProcess policy(pipes.to(), pipes.from(), options, work.context);
    const auto say = [&pipes, &answer = answer] { pipes.say(answer); };
    std::future<void> other = pipes.when_asked(say);
    CHECK_THROWS_WITH(ChoiceCall(work.context).ask(policy), Catch::Contains(words));
    other.get();
  }
}

TEST_CASE("Every question has one answer, one that has two is named", "[policy]") {
  const Pipes pipes;
  const Work work;
  PolicyProcess policy(pipes.to(), pipes.from(), options_of("x"), work.context);
  Question question;
  for (const int answers : {1, 1, 2}) {
    std::future<void> other = pipes.answer_when_asked(answers);
    question.ask(policy, work.context);
    other.get();
  }
  // Steps 0 to 2 were asked for; the last answer came twice.
  CHECK_THROWS_WITH(question.ask(policy, work.context),
                    Catch::Contains("48 bytes too many after its answer to step 2 of episode 7 of "
                                    "RememberColor3-VLA-v0"));
}

TEST_CASE("What a policy tells of itself may come before any answer", "[policy]") {
  const Pipes pipes;
  const Work work;
  std::vector<Json> told;
  PolicyProcessOptions options = options_of("x");
  options.identified = [&told](const Json& one) { told.push_back(one); };
  PolicyProcess policy(pipes.to(), pipes.from(), options, work.context);
  Question question;
  for (const char* text : {R"({"checkpoint": "a"})", "{}"}) {
    std::future<void> other = pipes.when_asked([&] {
      pipes.tell(text);
      pipes.answer();
    });
    question.ask(policy, work.context);
    other.get();
  }
  CHECK(told == std::vector<Json>{JsonTable{{"checkpoint", "a"}}, JsonTable{}});

  for (const char* text : {"", "[1]", "{\"checkpoint\": NaN}"}) {
    std::future<void> other = pipes.when_asked([&] { pipes.tell(text); });
    CHECK_THROWS_WITH(question.ask(policy, work.context), Catch::Contains("than a JSON object"));
    other.get();
  }
  std::future<void> other = pipes.when_asked([&] { pipes.say({9, 65'537}); });
  CHECK_THROWS_WITH(question.ask(policy, work.context), Catch::Contains("message type 9"));
  other.get();
}

TEST_CASE("A policy that tells of itself twice before an answer is refused", "[policy]") {
  const Pipes pipes;
  const Work work;
  PolicyProcess policy(pipes.to(), pipes.from(), options_of("x"), work.context);
  Question question;
  std::future<void> other = pipes.when_asked([&] {
    pipes.tell("{}");
    pipes.tell("{}");
  });
  CHECK_THROWS_WITH(question.ask(policy, work.context), Catch::Contains("message type 9"));
  other.get();
}

TEST_CASE("A second answer to the last question is found, too", "[policy]") {
  const Pipes pipes;
  const Work work;
  PolicyProcess policy(pipes.to(), pipes.from(), options_of("x"), work.context);
  Question question;
  std::future<void> other = pipes.answer_when_asked(1);
  question.ask(policy, work.context);
  other.get();
  CHECK_NOTHROW(policy.check_no_pending_reply());
  pipes.answer();
  CHECK_THROWS_WITH(policy.check_no_pending_reply(),
                    Catch::Contains("its answer to step 0 of episode 7"));
}

TEST_CASE("An answer that comes before its question is refused", "[policy]") {
  const Pipes pipes;
  const Work work;
  PolicyProcess policy(pipes.to(), pipes.from(), options_of("x"), work.context);
  pipes.answer();
  Question question;
  CHECK_THROWS_WITH(question.ask(policy, work.context), Catch::Contains("to the greeting"));
}

TEST_CASE("A policy that reads no question, or one byte now and then, is late", "[policy]") {
  const Work work;
  for (const bool reads : {false, true}) {
    const Pipes pipes;
    PolicyProcess policy(pipes.to(), pipes.from(), limited("x"), work.context);
    std::atomic<bool> done = false;
    std::thread reader([&] {
      while (reads && !done) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        pipes.read_page();
      }
    });
    Question question;
    question.instruction[0].resize(1 << 20);  // more than a pipe holds
    const auto start = Clock::now();
    CHECK_THROWS_WITH(question.ask(policy, work.context), Catch::Contains("within 1 s"));
    CHECK(Clock::now() - start < std::chrono::seconds(8));
    done = true;
    reader.join();
  }
}

}  // namespace
}  // namespace engram
