// Levels of perturbations as results and data sets have them.
#pragma once

#include <span>

#include "core/perturb/perturbation.h"
#include "protocol/io/json.h"

namespace engram {

// {axis: level} of those above 0, in the order of the axes; null if there is none.
Json perturbations_document(std::span<const PerturbationLevel> levels);

}  // namespace engram
