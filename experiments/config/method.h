// A structure, an integrator, a motion or a policy of change as an experiment or the command line names it.
#pragma once

#include "experiments/config/config_tree.h"
#include "framework/core/params.h"

#include <string>
#include <vector>

namespace etendue {

// Cuts a label into its words: a name, then each parameter as "key=value".
std::vector<std::string> words_of(const std::string& label);

struct Method {
  std::string name;
  ParamMap params;
  Location where = {};
  std::string shown_as = {};  // the experiment's own label, for reports alone; empty: it has none

  std::string label() const;  // "photon-map photons=200000": what logs call it, and reports where it is not `shown_as` another
};

// Check a method's name and parameters by making it, and spell integers one way ("200k" is 200000). Throw Error.
void validate_integrator(Method& method);
void validate_accel(Method& method);

// The default of renders: binned SAH, in the layout that suits scene and machine. Every structure and layout finds the same
// hits, so images do not depend on it. `auto` chooses its structure as well.
Method default_accel(const std::string& integrator = "");

// Every structure that is built in, with default parameters; also the better trees in wide layouts, and Embree in its
// watertight mode and with streams flagged as coherent.
std::vector<Method> all_accels(const Location& where);

// Whether a table { name, parameters… } may have a `label` beside them.
enum class OwnLabels : bool { refused, allowed };

// Names, tables { name, parameters… } (arrays of values: every combination), or an array; each label once. "all": all_accels.
std::vector<Method> read_integrators(const ConfigNode& node, OwnLabels own_labels = OwnLabels::refused);
std::vector<Method> read_accels(const ConfigNode& node, OwnLabels own_labels = OwnLabels::refused);
// One method's table, where a name stands for it, too; and with the entries of `changes` in the place of its own.
ConfigNode method_table(ConfigNode method);
ConfigNode method_table(ConfigNode method, const ConfigNode& changes, const std::string& owner);
Method read_method(const ConfigNode& table, bool of_structure);
// Motions and policies of change are read likewise, under the keys `dynamic.motions` and `dynamic.policies`.
std::vector<Method> read_motions(const ConfigNode& node);
std::vector<Method> read_policies(const ConfigNode& node);

// Removes the labels of such a value, which change no result.
void erase_own_labels(ConfigNode& node);

}  // namespace etendue
