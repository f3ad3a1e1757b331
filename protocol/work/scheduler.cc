#include "protocol/work/scheduler.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/thread_pool.h"

namespace engram {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick{100};
// How long a rank sleeps before it looks for messages again. A blocking receive would keep a core
// busy that the workers need.
constexpr std::chrono::milliseconds kPoll{1};

// --- the threads of one process ---

struct Done {
  std::uint64_t number = 0;
  Bytes result;
  std::exception_ptr error;
};

// Threads that work on items one by one.
class Crew {
 public:
  Crew(int threads, const WorkFunction& work) : work_(work) {
    try {
      for (int worker = 0; worker < threads; ++worker) {
        threads_.emplace_back([this, worker] { serve(worker); });
      }
    } catch (const std::exception& error) {
      dismiss();
      throw Error(Error::kUnavailable,
                  "threads: " + std::to_string(threads) + " given, the system allows " +
                      std::to_string(threads_.size()) + " (" + error.what() + ")");
    }
  }
  ~Crew() { dismiss(); }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  int threads() const { return static_cast<int>(threads_.size()); }
  std::uint64_t env_steps() const { return env_steps_.load(std::memory_order_relaxed); }

  void start(std::uint64_t number, const WorkItem& item) {
    const std::lock_guard lock(mutex_);
    stops_.try_emplace(number, std::make_unique<std::atomic<bool>>(false));
    done_.reserve(stops_.size());  // so that no thread ever runs out of memory for its result
    waiting_.push_back({number, item});
    arrived_.notify_one();
  }

  void stop(std::uint64_t number) {
    const std::lock_guard lock(mutex_);
    if (const auto found = stops_.find(number); found != stops_.end()) *found->second = true;
  }

  // Items done since the last call. If there are none, waits for one, but not longer than
  // `at_most`.
  std::vector<Done> wait(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    finished_.wait_for(lock, at_most, [this] { return !done_.empty(); });
    std::vector<Done> taken;
    taken.reserve(stops_.size());
    taken.swap(done_);
    for (const Done& done : taken) stops_.erase(done.number);
    return taken;
  }

 private:
  struct Order {
    std::uint64_t number;
    WorkItem item;
  };

  void dismiss() {
    {
      const std::lock_guard lock(mutex_);
      dismissed_ = true;
      for (const auto& [number, stopped] : stops_) *stopped = true;
      arrived_.notify_all();
    }
    for (std::thread& thread : threads_) thread.join();
  }

  void serve(int worker) {
    std::unique_lock lock(mutex_);
    while (true) {
      arrived_.wait(lock, [this] { return dismissed_ || !waiting_.empty(); });
      if (dismissed_) return;
      const Order order = waiting_.front();
      waiting_.pop_front();
      const std::atomic<bool>& stopped = *stops_.at(order.number);
      lock.unlock();
      Done done{order.number, {}, nullptr};
      try {
        if (!stopped) done.result = work_(order.item, WorkContext(worker, stopped, env_steps_));
      } catch (...) {
        done.error = std::current_exception();
      }
      lock.lock();
      done_.push_back(std::move(done));
      finished_.notify_one();
    }
  }

  const WorkFunction& work_;
  std::vector<std::thread> threads_;
  std::atomic<std::uint64_t> env_steps_ = 0;

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::condition_variable finished_;
  bool dismissed_ = false;
  std::deque<Order> waiting_;
  std::vector<Done> done_;
  std::map<std::uint64_t, std::unique_ptr<std::atomic<bool>>> stops_;
};

// --- messages ---

enum class Word : std::uint8_t {
  kReady,   // to rank 0: number of threads
  kItem,    // to a worker: number, item
  kStop,    // to a worker: number
  kResult,  // to rank 0: number, env steps so far, result
  kFailed,  // to rank 0: number, kind of error, message
  kEnd,     // to a worker: nothing more will come
  kLeft,    // to rank 0: the last message
};

ByteWriter say(Word word) {
  ByteWriter out;
  out.put(static_cast<std::uint8_t>(word));
  return out;
}

// --- rank 0 ---

class Leader {
 public:
  Leader(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source)
      : ranks_(ranks),
        source_(source),
        crew_(threads, work),
        members_(static_cast<std::size_t>(ranks.size())) {
    members_[0].threads = threads;
  }

  void run() {
    while (true) {
      hand_out();
      if (under_way_.empty()) break;
      for (Done& done : crew_.wait(ranks_.alone() ? kTick : kPoll)) {
        if (done.error) std::rethrow_exception(done.error);
        take(done.number, std::move(done.result));
      }
      members_[0].env_steps = crew_.env_steps();
      listen();
      stop_obsolete();
      tick();
    }
    dismiss();
  }

 private:
  struct Member {
    int threads = 0;  // 0: not heard of yet
    int under_way = 0;
    std::uint64_t env_steps = 0;
    bool left = false;
  };
  struct Assignment {
    WorkItem item;
    int rank = 0;
    bool stopped = false;
  };

  // One item to each rank in turn, until all threads have one or there is nothing.
  void hand_out() {
    for (bool any = true; any;) {
      any = false;
      for (std::size_t rank = 0; rank < members_.size(); ++rank) {
        Member& member = members_[rank];
        if (member.under_way >= member.threads) continue;
        const std::optional<WorkItem> item = source_.next();
        if (!item) return;
        ++member.under_way;
        any = true;
        under_way_[++last_number_] = {*item, static_cast<int>(rank), false};
        if (rank == 0) {
          crew_.start(last_number_, *item);
          continue;
        }
        ByteWriter message = say(Word::kItem);
        message.put(last_number_);
        message.put(item->task);
        message.put(item->first_seed);
        message.put(item->count);
        ranks_.send(static_cast<int>(rank), message.take());
      }
    }
  }

  void take(std::uint64_t number, Bytes result) {
    const auto found = under_way_.find(number);
    if (found == under_way_.end()) throw Error(Error::kInternal, "a result that nobody asked for");
    const Assignment assignment = found->second;
    under_way_.erase(found);
    --members_[static_cast<std::size_t>(assignment.rank)].under_way;
    if (!assignment.stopped) source_.accept(assignment.item, std::move(result));
  }

  void listen() {
    while (std::optional<Ranks::Message> message = ranks_.receive()) {
      Member& member = members_.at(static_cast<std::size_t>(message->from));
      ByteReader in(message->bytes);
      switch (static_cast<Word>(in.get<std::uint8_t>())) {
        case Word::kReady:
          member.threads = in.get<int>();
          break;
        case Word::kResult: {
          const auto number = in.get<std::uint64_t>();
          member.env_steps = in.get<std::uint64_t>();
          take(number, {in.rest().begin(), in.rest().end()});
          break;
        }
        case Word::kFailed: {
          const auto kind = static_cast<Error::Kind>(in.get<int>());
          throw Error(kind, "rank " + std::to_string(message->from) + ": " + in.text());
        }
        case Word::kLeft:
          member.left = true;
          break;
        default:
          throw Error(Error::kInternal, "a message that rank 0 does not know");
      }
    }
  }

  void stop_obsolete() {
    for (auto& [number, assignment] : under_way_) {
      if (assignment.stopped || !source_.obsolete(assignment.item)) continue;
      assignment.stopped = true;
      if (assignment.rank == 0) {
        crew_.stop(number);
        continue;
      }
      ByteWriter message = say(Word::kStop);
      message.put(number);
      ranks_.send(assignment.rank, message.take());
    }
  }

  void tick() {
    const Clock::time_point now = Clock::now();
    if (now < next_tick_) return;
    next_tick_ = now + kTick;
    WorkStatus status;
    status.under_way = static_cast<int>(under_way_.size());
    for (const Member& member : members_) status.env_steps += member.env_steps;
    source_.tick(status);
  }

  // Waits for the last message of every rank, so that none is left unread.
  void dismiss() {
    for (int rank = 1; rank < ranks_.size(); ++rank) ranks_.send(rank, say(Word::kEnd).take());
    members_[0].left = true;
    while (!std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.left; })) {
      listen();
      std::this_thread::sleep_for(kPoll);
    }
  }

  Ranks& ranks_;
  WorkSource& source_;
  std::map<std::uint64_t, Assignment> under_way_;
  std::uint64_t last_number_ = 0;
  Clock::time_point next_tick_{};
  Crew crew_;
  std::vector<Member> members_;
};

// --- the other ranks ---

void report(Ranks& ranks, Done& done, std::uint64_t env_steps) {
  if (!done.error) {
    ByteWriter message = say(Word::kResult);
    message.put(done.number);
    message.put(env_steps);
    message.append(std::span<const std::byte>(done.result));
    ranks.send(0, message.take());
    return;
  }
  auto kind = Error::kInternal;
  std::string text = "unknown failure";
  try {
    std::rethrow_exception(done.error);
  } catch (const Error& error) {
    kind = error.kind();
    text = error.what();
  } catch (const std::bad_alloc&) {
    kind = Error::kUnavailable;
    text = "out of memory";
  } catch (const std::exception& error) {
    text = error.what();
  }
  ByteWriter message = say(Word::kFailed);
  message.put(static_cast<int>(kind));
  message.put(std::string_view(text));
  ranks.send(0, message.take());
}

void follow(Ranks& ranks, int threads, const WorkFunction& work) {
  Crew crew(threads, work);
  ByteWriter ready = say(Word::kReady);
  ready.put(threads);
  ranks.send(0, ready.take());
  while (true) {
    for (Done& done : crew.wait(kPoll)) report(ranks, done, crew.env_steps());
    while (std::optional<Ranks::Message> message = ranks.receive()) {
      ByteReader in(message->bytes);
      switch (static_cast<Word>(in.get<std::uint8_t>())) {
        case Word::kItem: {
          const auto number = in.get<std::uint64_t>();
          WorkItem item;
          item.task = in.get<int>();
          item.first_seed = in.get<std::uint64_t>();
          item.count = in.get<int>();
          crew.start(number, item);
          break;
        }
        case Word::kStop:
          crew.stop(in.get<std::uint64_t>());
          break;
        case Word::kEnd:
          ranks.send(0, say(Word::kLeft).take());
          return;
        default:
          throw Error(Error::kInternal, "a message that this rank does not know");
      }
    }
  }
}

}  // namespace

int worker_threads(int threads, const Ranks& ranks) {
  if (threads > 0) return std::min(threads, ThreadPool::kMaxThreads);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::clamp(cores / ranks.local_size(), 1, ThreadPool::kMaxThreads);
}

void share_work(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source) {
  threads = worker_threads(threads, ranks);
  if (!ranks.leads()) {
    follow(ranks, threads, work);
    return;
  }
  Leader(ranks, threads, work, source).run();
}

}  // namespace engram
