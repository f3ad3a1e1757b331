#include "protocol/parallel/scheduler.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>

namespace engram {
namespace {

// Ranks that are threads of this process, with a mailbox each.
class Mailboxes {
 public:
  explicit Mailboxes(int size) : boxes_(static_cast<std::size_t>(size)) {}

  class MailboxRanks final : public Ranks {
   public:
    MailboxRanks(Mailboxes& all, int rank) : all_(all), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(all_.boxes_.size()); }
    void send(int to, Bytes bytes) override {
      const std::lock_guard lock(all_.mutex_);
      all_.boxes_.at(static_cast<std::size_t>(to)).push_back({rank_, std::move(bytes)});
    }
    std::optional<Message> receive() override {
      const std::lock_guard lock(all_.mutex_);
      auto& box = all_.boxes_[static_cast<std::size_t>(rank_)];
      if (box.empty()) return std::nullopt;
      Message message = std::move(box.front());
      box.pop_front();
      return message;
    }

   private:
    Mailboxes& all_;
    int rank_;
  };

 private:
  std::mutex mutex_;
  std::vector<std::deque<Ranks::Message>> boxes_;
};

void square(const WorkItem& item, const WorkContext& context) {
  ByteWriter out;
  out.put(item.first_seed * item.first_seed);
  context.emit(out.take());
}

// Squares of 0 to count - 1.
class Squares final : public WorkSource {
 public:
  explicit Squares(std::uint64_t count) : count_(count) {}

  std::optional<WorkItem> next() override {
    if (next_ == count_) return std::nullopt;
    return WorkItem{7, next_++, 1};
  }
  void accept(const WorkItem& item, Bytes result) override {
    CHECK(item.task == 7);
    CHECK(results.emplace(item.first_seed, ByteReader(result).get<std::uint64_t>()).second);
  }

  std::map<std::uint64_t, std::uint64_t> results;

 private:
  std::uint64_t count_;
  std::uint64_t next_ = 0;
};

void check_squares(const Squares& source, std::size_t count) {
  REQUIRE(source.results.size() == count);
  for (const auto& [number, result] : source.results) CHECK(result == number * number);
}

}  // namespace

TEST_CASE("Work: every item is done once, on all threads", "[work]") {
  for (const int threads : {1, 2, 5}) {
    Ranks alone;
    Squares source(100);
    std::mutex mutex;
    std::set<int> workers;
    distribute_work(
        alone, threads,
        [&](const WorkItem& item, const WorkContext& context) {
          const std::lock_guard lock(mutex);
          workers.insert(context.worker());
          square(item, context);
        },
        source);
    check_squares(source, 100);
    CHECK(*workers.begin() >= 0);
    CHECK(*workers.rbegin() < threads);
  }
}

TEST_CASE("Work: ranks share the items, and all of them end", "[work]") {
  for (const int size : {2, 3}) {
    Mailboxes mail(size);
    std::vector<std::thread> others;
    std::atomic<int> done_elsewhere = 0;
    for (int rank = 1; rank < size; ++rank) {
      others.emplace_back([&mail, &done_elsewhere, rank] {
        Mailboxes::MailboxRanks self(mail, rank);
        Squares unused(0);
        distribute_work(
            self, 2,
            [&](const WorkItem& item, const WorkContext& context) {
              ++done_elsewhere;
              square(item, context);
            },
            unused);
      });
    }
    Mailboxes::MailboxRanks self(mail, 0);
    Squares source(300);
    distribute_work(
        self, 1,
        [](const WorkItem& item, const WorkContext& context) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          square(item, context);
        },
        source);
    for (std::thread& other : others) other.join();
    check_squares(source, 300);
    CHECK(done_elsewhere > 0);
  }
}

TEST_CASE("Work: a failure anywhere ends the run with its message", "[work]") {
  const auto failing = [](const WorkItem& item, const WorkContext& context) {
    if (item.first_seed == 11) throw Error(Error::kUnavailable, "eleven is too much");
    square(item, context);
  };
  {
    Ranks alone;
    Squares source(100);
    CHECK_THROWS_WITH(distribute_work(alone, 2, failing, source), "eleven is too much");
    CHECK(!source.results.contains(11));
  }
  Mailboxes mail(2);
  std::thread other([&] {
    Mailboxes::MailboxRanks self(mail, 1);
    Squares unused(0);
    distribute_work(self, 1, failing, unused);
  });
  Mailboxes::MailboxRanks self(mail, 0);
  Squares source(12);
  // This rank is held up, so that the other one comes to the bad item.
  const auto slow = [](const WorkItem& item, const WorkContext& context) {
    while (!context.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    square(item, context);
  };
  CHECK_THROWS_WITH(distribute_work(self, 1, slow, source), "rank 1: eleven is too much");
  // Stands for abort() of MPI.
  ByteWriter end;
  end.put(std::uint8_t{5});
  self.send(1, end.take());
  other.join();
}

TEST_CASE("Work: obsolete items are stopped and not accepted", "[work]") {
  class Endless final : public WorkSource {
   public:
    std::optional<WorkItem> next() override {
      if (number_ == 2) return std::nullopt;
      return WorkItem{0, number_++, 1};
    }
    void accept(const WorkItem& item, Bytes) override { accepted.push_back(item.first_seed); }
    bool obsolete(const WorkItem& item) override {
      return item.first_seed == 0 && !accepted.empty();
    }
    std::vector<std::uint64_t> accepted;

   private:
    std::uint64_t number_ = 0;
  };
  Ranks alone;
  Endless source;
  distribute_work(
      alone, 2,
      [](const WorkItem& item, const WorkContext& context) {
        // The first item would never end by itself.
        while (item.first_seed == 0 && !context.stopped()) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        context.emit({});
      },
      source);
  CHECK(source.accepted == std::vector<std::uint64_t>{1});
}

TEST_CASE("Work: results of an item are accepted while it goes on, in their order", "[work]") {
  class Letters final : public WorkSource {
   public:
    std::optional<WorkItem> next() override {
      if (std::exchange(begun_, true)) return std::nullopt;
      return WorkItem{0, 0, 3};
    }
    void accept(const WorkItem&, Bytes result) override {
      accepted.push_back(ByteReader(result).get<char>());
      arrived.fetch_add(1);
    }
    std::string accepted;
    std::atomic<int> arrived = 0;

   private:
    bool begun_ = false;
  };
  Letters source;
  const auto spell = [&source](const WorkItem& item, const WorkContext& context) {
    for (int i = 0; i < item.count; ++i) {
      ByteWriter out;
      out.put("abc"[i]);
      context.emit(out.take());
      // The next one waits until this one has been taken.
      while (source.arrived.load() <= i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  Ranks alone;
  distribute_work(alone, 1, spell, source);
  CHECK(source.accepted == "abc");
}

TEST_CASE("Work: results before a failure are kept", "[work]") {
  Ranks alone;
  Squares source(1);
  const auto broken = [](const WorkItem& item, const WorkContext& context) {
    square(item, context);
    throw Error(Error::kUnavailable, "broken");
  };
  CHECK_THROWS_WITH(distribute_work(alone, 1, broken, source), "broken");
  check_squares(source, 1);
}

}  // namespace engram
