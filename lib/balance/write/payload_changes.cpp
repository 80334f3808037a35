#include "balance/write/payload_changes.hpp"

#include "balance/result/quantities.hpp"

#include <fmt/format.h>

#include <vector>

namespace balance {
namespace {

using Change = PayloadEvent;

/// As long as its round-off allows; 0 stays 0.
std::string effort_text(const RunResult& result, const VectorX& efforts, std::size_t actuator) {
  const auto a = static_cast<Eigen::Index>(actuator);
  const VectorX& known = result.round_off.effort;
  const double zero = a < known.size() ? known[a] : 0;
  return fmt::format("{:.5g}", std::abs(efforts[a]) <= zero ? 0 : efforts[a]);
}

}  // namespace

std::string format_payload_events(const RunResult& result) {
  std::string text;
  for (const Change& change : result.payload_events) {
    text += fmt::format("{} {} at {:.6g} s", change.payload, describe_payload_event(change), change.time);
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a)
      text += fmt::format("{} {} from {} to {} {}", a == 0 ? ":" : ",", result.actuator_names[a],
                          effort_text(result, change.effort_before, a), effort_text(result, change.effort_after, a),
                          result.actuator_units[a]);
    text += "\n";
  }
  return text;
}

Json payload_events_json(const RunResult& result) {
  Json all = Json::array();
  for (const Change& change : result.payload_events) {
    Json torque = Json::array();
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      torque.push_back({{"actuator", result.actuator_names[a]},
                        {"unit", result.actuator_units[a]},
                        {"before", change.effort_before[i]},
                        {"after", change.effort_after[i]}});
    }
    all.push_back({{"payload", change.payload},
                   {"change", describe_payload_event(change)},
                   {"time", change.time},
                   {"speed", change.speed},
                   {"turning", change.angular_speed},
                   {"torque", std::move(torque)}});
  }
  return all;
}

void write_payload_events(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result) {
  const std::vector<Change>& all = result.payload_events;
  if (all.empty()) return;
  const Hdf5Writer::Group group = file.add_group(parent, "payload_changes");
  std::vector<std::string> labels;
  for (const Change& change : all) labels.push_back(change.payload + " " + describe_payload_event(change));
  const Hdf5Writer::Dimension each =
      file.add_dimension(group, {"change", "payload taken up or set down", "1", {}, {}}, labels);
  const auto add = [&](const char* name, const char* long_name, const char* unit, double Change::*number) {
    std::vector<double> values;
    for (const Change& change : all) values.push_back(change.*number);
    file.add_variable(group, {name, long_name, unit, {each}, {}}, values);
  };
  add("switch_time", "when it changes", "s", &Change::time);
  add("speed", "speed of the payload's place then", "m/s", &Change::speed);
  add("turning", "angular velocity of its body then, where it has a moment of inertia", "rad/s",
      &Change::angular_speed);
  if (result.actuator_names.empty()) return;
  const Hdf5Writer::Dimension actuator =
      file.add_dimension(group, {"actuator", "actuated joint coordinate", "1", {}, {}}, result.actuator_names);
  const auto add_efforts = [&](const char* name, const char* long_name, VectorX Change::*efforts) {
    std::vector<double> values;
    for (const Change& change : all) values.insert(values.end(), (change.*efforts).begin(), (change.*efforts).end());
    file.add_variable(group, {name, long_name, common_unit(result.actuator_units), {each, actuator}, {}}, values);
  };
  add_efforts("torque_before", "torque or force of the actuator just before", &Change::effort_before);
  add_efforts("torque_after", "torque or force of the actuator just after", &Change::effort_after);
}

}  // namespace balance
