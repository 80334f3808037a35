#include "balance/motion/study/study.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <algorithm>

namespace balance::study {

namespace {

std::string describe_unknown_name(const std::string& spec_file, const std::string& kind, const std::string& name,
                                  const std::vector<std::string>& known) {
  std::string text = spec_file + " has no " + kind + " " + quote_for_message(name) + ", only ";
  for (std::size_t k = 0; k < known.size(); ++k) text += (k == 0 ? "" : ", ") + known[k];
  return text + append_nearest_name(name, known);
}

template <class T>
const T& require_name(const Study& study, const std::vector<T>& items, const char* kind, const std::string& name) {
  if (const T* match = find_by_name(items, name)) return *match;
  std::vector<std::string> known;
  for (const T& item : items) known.push_back(item.name);
  throw UnknownNameError(study.spec_file, kind, name, std::move(known));
}

}  // namespace

UnknownNameError::UnknownNameError(const std::string& spec_file, const std::string& kind, std::string name,
                                   std::vector<std::string> known)
    : std::invalid_argument(describe_unknown_name(spec_file, kind, name, known)),
      name_(std::move(name)),
      known_(std::move(known)) {}

std::size_t trajectory_index(const Study& study, const std::string& name) {
  return static_cast<std::size_t>(&require_name(study, study.trajectories, "trajectory", name) -
                                  study.trajectories.data());
}

const Trajectory& choose_trajectory(const Study& study, const std::string& name) {
  if (study.trajectories.empty())
    throw SpecError({.place = {.file = study.spec_file}, .message = "there is no motion to simulate"});
  if (name.empty()) return study.trajectories.front();
  return require_name(study, study.trajectories, "trajectory", name);
}

const Controller& choose_controller(const Study& study, const std::string& name) {
  if (!name.empty()) return require_name(study, study.controllers, "controller", name);
  const std::vector<Controller> built_in = built_in_controllers();  // they follow those of the spec
  const Controller& first = study.controllers.front();
  if (study.controllers.size() > built_in.size() || first.name != built_in.front().name) return first;
  return require_name(study, study.controllers, "controller", controller_type_name(ControllerType::computed_torque));
}

void reject_temporary_payloads(const Study& study, const std::string& what, const std::vector<std::string>* without) {
  const auto is_excluded = [&](const std::string& name) {
    return without != nullptr && std::find(without->begin(), without->end(), name) != without->end();
  };
  if (is_excluded("payloads")) return;
  for (const TemporaryPayload& payload : study.temporary_payloads) {
    if (is_excluded(payload.name)) continue;
    const std::string expected = "payloads that are always there, for " + what;
    const std::string found = "'" + payload.name + "', which is taken up or set down on the way";
    const std::string hint = without == nullptr ? "" : "--without " + payload.name + " leaves it out";
    throw SpecError({.place = payload.place,
                     .message = "expected " + expected + ", found " + found + (hint.empty() ? "" : "; " + hint),
                     .expected = expected,
                     .found = found,
                     .hint = hint});
  }
}

}  // namespace balance::study
