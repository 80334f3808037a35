#include "balance/motion/study/study.hpp"

#include "balance/mechanics/trajectory/adaptation.hpp"

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

Mechanism mechanism_along(const Study& study, const std::string& name) {
  const Trajectory* trajectory = find_by_name(study.trajectories, name);
  return trajectory == nullptr ? study.mechanism : model_adaptations(study.mechanism, *trajectory).mechanism;
}

Mechanism mechanism_with_slides(const Study& study) {
  constexpr double direction_tolerance = 1e-9;
  Mechanism mechanism = study.mechanism;
  const auto find_slide = [&](const std::string& name) {
    return std::find_if(mechanism.joints.begin() + static_cast<std::ptrdiff_t>(study.mechanism.joints.size()),
                        mechanism.joints.end(), [&](const Joint& joint) { return joint.name == name; });
  };
  for (Trajectory trajectory : study.trajectories) {
    if (trajectory.adaptations.empty()) continue;
    const Mechanism moved = model_adaptations(study.mechanism, trajectory).mechanism;
    std::erase_if(trajectory.adaptations, [&](const trajectory::Adaptation& adaptation) {
      const std::string& name = study.mechanism.attachments[static_cast<std::size_t>(adaptation.attachment)].name;
      const auto slide = find_slide(name);
      if (slide == mechanism.joints.end()) return false;
      const Joint& other = *find_by_name(moved.joints, name);
      if ((slide->axis - other.axis).norm() > direction_tolerance)
        throw std::invalid_argument("counterweight '" + name + "' moves along different lines in two trajectories");
      return true;
    });
    mechanism = model_adaptations(mechanism, trajectory).mechanism;
  }
  return mechanism;
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
    const std::string hint =
        without == nullptr
            ? ""
            : "--without " + payload.name +
                  " leaves it out; without 'from' and 'until', load cases (for) balance with and without it";
    throw SpecError({.place = payload.place,
                     .message = "expected " + expected + ", found " + found + (hint.empty() ? "" : "; " + hint),
                     .expected = expected,
                     .found = found,
                     .hint = hint});
  }
}

}  // namespace balance::study
