#include "core/contact/islands.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace engram {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace

Islands::Islands(int movers, int contacts)
    : linked_(at(movers)),
      island_(at(movers)),
      begin_(at(movers)),
      size_(at(movers)),
      next_(at(movers)),
      movers_(at(movers)),
      mover_begin_(at(movers + 1)),
      contacts_(at(contacts)),
      contact_begin_(at(movers + 1)) {}

int Islands::first_of(int mover) {
  while (linked_[at(mover)] != mover) mover = linked_[at(mover)] = linked_[at(linked_[at(mover)])];
  return mover;
}

void Islands::find(ContactConstraints& rows, int movers) {
  link(rows, movers);
  // An island gets its number when its first mover comes.
  count_ = 0;
  for (int mover = 0; mover < movers; ++mover) {
    if (rows.contacts_of(mover) == 0) continue;
    const int first = first_of(mover);
    if (first == mover) {
      size_[at(count_)] = 0;
      mover_begin_[at(count_ + 1)] = contact_begin_[at(count_ + 1)] = 0;
      island_[at(mover)] = count_++;
    }
    const int island = island_[at(mover)] = island_[at(first)];
    begin_[at(mover)] = size_[at(island)];
    size_[at(island)] += mover == kRobotBody ? kRobotWidth : kPropWidth;
    ++mover_begin_[at(island + 1)];
  }
  for (ContactConstraints::Contact& contact : rows.contacts()) {
    ++contact_begin_[at(island_[at(contact.movers[0])] + 1)];
    for (std::size_t i = 0; i < 2 && contact.movers[i] != kNoBody; ++i) {
      contact.cone.begin[i] = begin_[at(contact.movers[i])];
    }
  }
  sort(rows, movers);
}

void Islands::link(const ContactConstraints& rows, int movers) {
  std::iota(linked_.begin(), linked_.begin() + movers, 0);
  for (const ContactConstraints::Contact& contact : rows.contacts()) {
    if (contact.movers[1] == kNoBody) continue;
    const int first = first_of(contact.movers[0]);
    const int second = first_of(contact.movers[1]);
    linked_[at(std::max(first, second))] = std::min(first, second);
  }
}

// By island, from how many there are of each.
void Islands::sort(const ContactConstraints& rows, int movers) {
  for (int island = 0; island < count_; ++island) {
    mover_begin_[at(island + 1)] += mover_begin_[at(island)];
    contact_begin_[at(island + 1)] += contact_begin_[at(island)];
  }
  std::copy_n(mover_begin_.begin(), count_, next_.begin());
  for (int mover = 0; mover < movers; ++mover) {
    if (rows.contacts_of(mover) > 0) movers_[at(next_[at(island_[at(mover)])]++)] = mover;
  }
  std::copy_n(contact_begin_.begin(), count_, next_.begin());
  for (const ContactConstraints::Contact& contact : rows.contacts()) {
    contacts_[at(next_[at(island_[at(contact.movers[0])])]++)] = &contact.cone;
  }
}

}  // namespace engram
