// Coulomb friction of sliding balls. MuJoCo's friction lifts sliding bodies: contacts separate at a
// speed in proportion to the slip, so that a ball that is launched at 1 m/s hops and loses in one
// substep the speed that friction takes in seven.
#pragma once

#include "core/contact/contact_constraints.h"

namespace engram {

// Applies Coulomb friction, mu times the normal force against the slip, to free bodies that slide
// on the table with a single contact. Bodies that friction stops within this substep, and all
// others, keep MuJoCo's friction. Changes reference accelerations of rows; needs the accelerations
// without contacts.
void apply_coulomb_sliding(const SceneModel& scene, mjData& data, const ContactConstraints& rows);

}  // namespace engram
