// Which movers touch one another, and so have to be solved together. Every island is solved by
// itself: what else is in the scene does not change a bit of it.
#pragma once

#include <span>
#include <vector>

#include "core/contact/contact_constraints.h"

namespace engram {

class Islands {
 public:
  // Room for so many movers and contacts.
  Islands(int movers, int contacts);

  // Groups those that have contacts, of so many movers, and tells every contact where its movers'
  // velocities are within their island.
  void find(ContactConstraints& rows, int movers);

  int count() const { return count_; }
  // In ascending order, and in MuJoCo's.
  std::span<const int> movers(int island) const { return part(movers_, mover_begin_, island); }
  std::span<const ConeContact* const> contacts(int island) const {
    return part(contacts_, contact_begin_, island);
  }
  // Where a mover's velocity begins within its island.
  int begin_of(int mover) const { return begin_[static_cast<std::size_t>(mover)]; }
  bool holds_robot(int island) const { return movers(island).front() == kRobotBody; }

 private:
  template <class T>
  static std::span<const T> part(const std::vector<T>& all, const std::vector<int>& begin,
                                 int island) {
    const auto i = static_cast<std::size_t>(island);
    const auto from = static_cast<std::size_t>(begin[i]);
    return {all.data() + from, static_cast<std::size_t>(begin[i + 1]) - from};
  }
  void link(const ContactConstraints& rows, int movers);
  void sort(const ContactConstraints& rows, int movers);
  int first_of(int mover);

  int count_ = 0;
  std::vector<int> linked_;  // of each mover: one before it of the same island, or itself
  std::vector<int> island_;
  std::vector<int> begin_;
  std::vector<int> size_;  // of each island's velocities
  std::vector<int> next_;
  std::vector<int> movers_;
  std::vector<int> mover_begin_;
  std::vector<const ConeContact*> contacts_;
  std::vector<int> contact_begin_;
};

}  // namespace engram
