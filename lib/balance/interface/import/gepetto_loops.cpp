// Gepetto loop files.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::foreign {

namespace {

using specification::Presence;
using specification::SpecCursor;

/// Whether the radius of gyration is smaller than that of a solid ball of the same mass and the
/// densest matter, 22600 kg/m³.
bool is_denser_than_matter(const Body& body) {
  const double k = std::sqrt(body.inertia.trace() / 2 / body.mass);
  const double radius = std::cbrt(3 * body.mass / (4 * std::numbers::pi * 22600));
  return k < std::sqrt(3.0 / 5.0) * radius;
}

class GepettoLoopReader {
 public:
  GepettoLoopReader(const std::string& file, ForeignModel& robot) : problems_(file), file_(file), robot_(robot) {}

  void run(const std::string& text) {
    try {
      const specification::YamlNode root = specification::parse_yaml(text, problems_);
      const SpecCursor cursor(root, "", problems_);
      if (!cursor.is_map()) cursor.fail_expected("a mapping with 'closed_loop'");
      for (const specification::Member& member : specification::list_members(cursor, "a mapping with 'closed_loop'"))
        problems_.collect([&] { read_key(member); });
      if (loops_.empty() && problems_.is_empty()) cursor.fail_missing({"closed_loop"});
      if (problems_.is_empty()) problems_.collect([&] { close_loops(); });
    } catch (const specification::ReadError& error) {
      problems_.add(error);
    }
    problems_.throw_if_any();
    clear_marker_masses(robot_, closure_bodies_);
  }

 private:
  void read_key(const specification::Member& member) {
    const SpecCursor& value = member.value;
    if (member.name == "closed_loop") {
      const auto pairs = value.items("a list of pairs [A, B]");
      if (pairs.empty()) value.fail_expected("at least one pair [A, B]");
      if (pairs.size() > max_model_elements) value.fail_expected(fmt::format("at most {} loops", max_model_elements));
      for (const SpecCursor& pair : pairs) {
        const auto frame_names = pair.items("a pair [A, B] of joints or links", 2);
        loops_.push_back({frame(frame_names[0]), frame(frame_names[1])});
        names_.push_back(frame_names[0].read_word("a name"));
        locations_.push_back({file_, pair.node().place.line, pair.node().place.column, ""});
      }
    } else if (member.name == "type") {
      for (const SpecCursor& item : value.items("a list of 6d and 3d"))
        types_.push_back(item.read_choice("how the loop closes", {"6d", "6D", "3d", "3D"}) < 2 ? JointType::fixed
                                                                                               : JointType::spherical);
      type_location_ = value.node().place;
    } else if (member.name == "name_mot") {
      for (const SpecCursor& item : value.items("a list of joints")) read_actuated_joints(item);
      robot_.declares_actuators = true;
    } else {
      ++robot_.ignored["'" + member.name + "' of " + file_];
    }
  }

  std::vector<std::string> all_names() const {
    std::vector<std::string> names;
    for (const ForeignBody& body : robot_.bodies) names.push_back(body.body.name);
    for (const ForeignJoint& joint : robot_.joints) names.push_back(joint.joint.name);
    return names;
  }

  /// Frame of a link; a joint stands for the link that it carries.
  BodyFrame frame(const SpecCursor& at) {
    const std::string& name = at.read_word("a joint's or a link's name");
    const int joint = robot_.find_joint(name);
    const BodyId body = robot_.find_body(name);
    if (joint < 0 && body < 0)
      at.fail({.expected = "a joint or a link",
               .found = quote_for_message(name),
               .hint = format_nearest_name(name, all_names())});
    const BodyId link = joint >= 0 ? robot_.joints[static_cast<std::size_t>(joint)].joint.second : body;
    closure_bodies_.push_back(link);
    return {link, {}};
  }

  void read_actuated_joints(const SpecCursor& at) {
    const std::string& name = at.read_word("a joint's name");
    const int joint = robot_.find_joint(name);
    if (joint < 0)
      at.fail(
          {.expected = "a joint", .found = quote_for_message(name), .hint = format_nearest_name(name, all_names())});
    robot_.joints[static_cast<std::size_t>(joint)].is_actuated = true;
  }

  void close_loops() {
    if (!types_.empty() && types_.size() != loops_.size())
      throw specification::ReadError(
          type_location_, "type",
          {.expected = fmt::format("one for each of {} loops", loops_.size()), .found = std::to_string(types_.size())});
    for (std::size_t i = 0; i < loops_.size(); ++i) {
      if (loops_[i].first.body == loops_[i].second.body)
        throw specification::ReadError({locations_[i].line, locations_[i].column}, fmt::format("closed_loop[{}]", i),
                                       {.expected = "frames of two links", .found = "two of the same"});
      add_loop_joint(robot_, names_[i] + "_closed", types_.empty() ? JointType::fixed : types_[i], loops_[i].first,
                     loops_[i].second, Vector3::UnitZ(), locations_[i]);
    }
  }

  specification::SpecErrorCollector problems_;
  std::string file_;
  ForeignModel& robot_;
  std::vector<std::pair<BodyFrame, BodyFrame>> loops_;
  std::vector<std::string> names_;
  std::vector<SourceLocation> locations_;
  std::vector<JointType> types_;
  specification::NodeLocation type_location_;
  std::vector<int> closure_bodies_;
};

}  // namespace

void clear_marker_masses(ForeignModel& robot, const std::vector<int>& named_bodies) {
  double total_mass = 0;
  bool has_shapes = false;
  for (const ForeignBody& one : robot.bodies) {
    total_mass += one.body.mass;
    has_shapes = has_shapes || one.has_geometry;
  }
  for (const int b : named_bodies) {
    ForeignBody& marker = robot.bodies[static_cast<std::size_t>(b)];
    Body& body = marker.body;
    const auto is_child_joint = [b](const ForeignJoint& one) {
      return !one.is_loop_closure && one.is_active && one.joint.first == b;
    };
    const bool is_leaf = std::none_of(robot.joints.begin(), robot.joints.end(), is_child_joint);
    if (b == 0 || !is_leaf || !(body.mass > 0)) continue;
    const bool lacks_shape = has_shapes && !marker.has_geometry;
    if (!lacks_shape && !is_denser_than_matter(body) && body.mass > 1e-6 * total_mass) continue;
    robot.findings.push_back(
        {Severity::note, marker.place, "marker", fmt::format("link {}", quote_for_message(body.name)),
         fmt::format("only marks where a loop closes: its mass of {:.6g} kg is left out", body.mass)});
    body.mass = 0;
    body.com.setZero();
    body.inertia.setZero();
    marker.has_inertial = false;
    marker.is_marker = true;
  }
}

void read_gepetto_loops(const std::string& text, const std::string& file, ForeignModel& robot) {
  GepettoLoopReader(file, robot).run(text);
}

}  // namespace balance::foreign
