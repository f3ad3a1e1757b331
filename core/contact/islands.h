// Islands: dynamic bodies that touch one another, directly or through others, found by union-find.
// Every island is solved by itself, so the rest of the scene does not change a bit of its motion.
#pragma once

#include <span>
#include <vector>

#include "core/contact/contact_constraints.h"

namespace engram {

class Islands {
 public:
  // Allocates for so many dynamic bodies and contacts.
  Islands(int bodies, int contacts);

  // Groups the bodies that have contacts, out of `bodies`, and sets every contact's velocity ranges
  // within its island.
  void find(ContactConstraints& rows, int bodies);

  int count() const { return count_; }
  // Bodies in ascending order; contacts in MuJoCo's order.
  std::span<const int> bodies(int island) const { return range(bodies_, body_begin_, island); }
  std::span<const ConeContact* const> contacts(int island) const {
    return range(contacts_, contact_begin_, island);
  }
  // Index of a body's first velocity within its island.
  int begin_of(int body) const { return begin_[static_cast<std::size_t>(body)]; }
  bool holds_robot(int island) const { return bodies(island).front() == kRobotBody; }

 private:
  template <class T>
  static std::span<const T> range(const std::vector<T>& all, const std::vector<int>& begin,
                                  int island) {
    const auto i = static_cast<std::size_t>(island);
    const auto from = static_cast<std::size_t>(begin[i]);
    return {all.data() + from, static_cast<std::size_t>(begin[i + 1]) - from};
  }
  void unite_touching(const ContactConstraints& rows, int bodies);
  void sort(const ContactConstraints& rows, int bodies);
  int find_root(int body);

  int count_ = 0;
  std::vector<int> parent_;  // of each body in the union-find forest; roots are their own
  std::vector<int> island_;
  std::vector<int> begin_;
  std::vector<int> size_;  // number of each island's velocities
  std::vector<int> next_;
  std::vector<int> bodies_;
  std::vector<int> body_begin_;
  std::vector<const ConeContact*> contacts_;
  std::vector<int> contact_begin_;
};

}  // namespace engram
