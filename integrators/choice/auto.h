// The method that a pilot finds best for the scene and the effort stated (integrators/choice/choose.h).
//
// A pilot of 90,000 to 200,000 rays comes first, and counts in the budget like any preparation. From then on everything is the
// chosen method's: the image has the bits that it would have under its own name with the same seed. `choice()` says which it
// is, and why, in one sentence.
//
// It is unbiased, consistent or biased as the chosen method is.
#pragma once

#include "integrators/choice/choose.h"

namespace etendue {

struct AutoParams {
  BiasAllowed bias = BiasAllowed::any;
  float seconds = 0;
};

template <class Visitor>
void describe(Visitor& v, AutoParams& p) {
  v.choice("bias", p.bias, "of the methods to choose from: any, one that vanishes with iterations, or none");
  v.number("seconds", p.seconds, 0, 1e9, "s", "choose for an image at that time; 0: at the end of the budget");
}

IntegratorEntry auto_entry();

// What the method is chosen for, and its structure with it: `told`, or the seconds that `auto` was given.
Effort effort_chosen_for(const std::string& method, const ParamMap& params, const Effort& told);

}  // namespace etendue
