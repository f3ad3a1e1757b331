#include "core/contact/islands.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/base/index.h"

namespace engram {
Islands::Islands(int bodies, int contacts)
    : parent_(at(bodies)),
      island_(at(bodies)),
      begin_(at(bodies)),
      size_(at(bodies)),
      next_(at(bodies)),
      bodies_(at(bodies)),
      body_begin_(at(bodies + 1)),
      contacts_(at(contacts)),
      contact_begin_(at(bodies + 1)) {}

// Finds the root with path halving.
int Islands::find_root(int body) {
  while (parent_[at(body)] != body) body = parent_[at(body)] = parent_[at(parent_[at(body)])];
  return body;
}

void Islands::find(ContactConstraints& rows, int bodies) {
  unite_touching(rows, bodies);
  // Islands are numbered in the order of their first bodies.
  count_ = 0;
  for (int body = 0; body < bodies; ++body) {
    if (rows.contacts_of(body) == 0) continue;
    const int root = find_root(body);
    if (root == body) {
      size_[at(count_)] = 0;
      body_begin_[at(count_ + 1)] = contact_begin_[at(count_ + 1)] = 0;
      island_[at(body)] = count_++;
    }
    const int island = island_[at(body)] = island_[at(root)];
    begin_[at(body)] = size_[at(island)];
    size_[at(island)] += body == kRobotBody ? kRobotWidth : kPropWidth;
    ++body_begin_[at(island + 1)];
  }
  for (ContactConstraints::Contact& contact : rows.contacts()) {
    ++contact_begin_[at(island_[at(contact.bodies[0])] + 1)];
    for (std::size_t i = 0; i < 2 && contact.bodies[i] != kNoBody; ++i) {
      contact.cone.begin[i] = begin_[at(contact.bodies[i])];
    }
  }
  sort(rows, bodies);
}

void Islands::unite_touching(const ContactConstraints& rows, int bodies) {
  std::iota(parent_.begin(), parent_.begin() + bodies, 0);
  for (const ContactConstraints::Contact& contact : rows.contacts()) {
    if (contact.bodies[1] == kNoBody) continue;
    const int first = find_root(contact.bodies[0]);
    const int second = find_root(contact.bodies[1]);
    parent_[at(std::max(first, second))] = std::min(first, second);
  }
}

// Counting sort of bodies and contacts by island.
void Islands::sort(const ContactConstraints& rows, int bodies) {
  for (int island = 0; island < count_; ++island) {
    body_begin_[at(island + 1)] += body_begin_[at(island)];
    contact_begin_[at(island + 1)] += contact_begin_[at(island)];
  }
  std::copy_n(body_begin_.begin(), count_, next_.begin());
  for (int body = 0; body < bodies; ++body) {
    if (rows.contacts_of(body) > 0) bodies_[at(next_[at(island_[at(body)])]++)] = body;
  }
  std::copy_n(contact_begin_.begin(), count_, next_.begin());
  for (const ContactConstraints::Contact& contact : rows.contacts()) {
    contacts_[at(next_[at(island_[at(contact.bodies[0])])]++)] = &contact.cone;
  }
}

}  // namespace engram
