// Balls that slide. MuJoCo's friction lifts what slides: its contacts part at a speed in proportion
// to the slip, so that a ball that is launched at 1 m/s hops and loses in one substep what friction
// takes in seven.
#pragma once

#include "core/contact/contact_constraints.h"

namespace engram {

// Lets a free body that slides on the table with a single contact feel Coulomb's friction: the
// share mu of the normal force, against the slip. For bodies that friction stops within this
// substep, and for all others, nothing changes. Changes reference accelerations of rows; needs the
// accelerations without contacts.
void apply_coulomb_sliding(const SceneModel& scene, mjData& data, const ContactConstraints& rows);

}  // namespace engram
