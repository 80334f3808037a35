#include "balance/interface/import/foreign_readers.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/foreign_yaml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numbers>

namespace balance::foreign {

namespace {

using specification::SpecCursor;
using Entries = std::map<std::string, SpecCursor>;

const SpecCursor* find_value(const Entries& map, const std::string& key) {
  const auto match = map.find(key);
  return match == map.end() ? nullptr : &match->second;
}

const SpecCursor& require_value(const Entries& map, const SpecCursor& at, const std::string& key) {
  const SpecCursor* match = find_value(map, key);
  if (match == nullptr) at.fail_missing({key});
  return *match;
}

/// Reads a word in any case, with `_`, `-` or blanks; returns it in upper case with `_`.
std::string read_keyword(const Entries& map, const std::string& key, const std::string& fallback) {
  const SpecCursor* at = find_value(map, key);
  std::string word = at == nullptr ? fallback : at->read_word("a word");
  for (char& c : word) c = c == '-' || c == ' ' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return word;
}

class ChronoReader {
 public:
  explicit ChronoReader(const std::string& file) : file_(file) {}

  ForeignModel run(const SpecCursor& root) {
    robot_.format = "Chrono";
    robot_.file = file_;
    ForeignBody ground;
    ground.body.name = "ground";
    ground.place = place_of(root);
    robot_.bodies.push_back(std::move(ground));
    poses_.emplace_back();
    const Entries root_entries = read_mapping(root, "a Chrono model");
    const SpecCursor& at = require_value(root_entries, root, "model");
    const Entries model = read_mapping(at, "a model");
    if (const SpecCursor* name = find_value(model, "name")) robot_.name = name->read_word("a name");
    if (const SpecCursor* degrees = find_value(model, "angle_degrees"))
      angle_unit_ = read_bool(*degrees) ? std::numbers::pi / 180 : 1;
    read_items(require_value(model, at, "bodies"), "a list of bodies", &ChronoReader::read_body);
    root.problems().throw_if_any();
    for (const auto& [key, read] : {std::pair{"joints", &ChronoReader::read_joint},
                                    {"motors", &ChronoReader::read_motor},
                                    {"tsdas", &ChronoReader::read_spring}})
      if (const SpecCursor* list = find_value(model, key)) read_items(*list, std::string("a list of ") + key, read);
    report_unsupported_sections(model);
    root.problems().throw_if_any();
    add_finding(Severity::note, root, "gravity", "gravity", "is not part of the model: (0, 0, -9.81) is used");
    return std::move(robot_);
  }

 private:
  using Reader = void (ChronoReader::*)(const SpecCursor&);

  void read_items(const SpecCursor& list, const std::string& what, Reader read) {
    list.problems().collect([&] {
      const auto items = list.items(what);
      if (items.size() > 2000) list.fail_expected("at most 2000 entries");
      specification::read_each(items, [&](const SpecCursor& at) { (this->*read)(at); });
    });
  }

  SourceLocation place_of(const SpecCursor& at) const {
    return {file_, at.node().place.line, at.node().place.column, ""};
  }

  void add_finding(Severity severity, const SpecCursor& at, const char* code, const std::string& subject,
                   const std::string& message) {
    robot_.findings.push_back({severity, place_of(at), code, subject, message});
  }

  void report_unsupported_sections(const Entries& model) {
    if (const SpecCursor* constraints = find_value(model, "constraints");
        constraints != nullptr && !constraints->node().items.empty())
      constraints->problems().collect(
          [&] { constraints->fail_expected("joints only: constraints between points are not read"); });
    for (const char* key : {"rsdas", "body_loads", "load_controllers"})
      if (const SpecCursor* list = find_value(model, key); list != nullptr && !list->node().items.empty())
        add_finding(Severity::warning, *list, "left-out", key,
                    fmt::format("{} of them left out", list->node().items.size()));
  }

  Matrix3 orientation(const SpecCursor& at) const {
    const auto v = plain_numbers(at, "[yaw, pitch, roll] or a quaternion", {3, 4});
    if (v.size() == 3) return rotation_from_rpy(Vector3(v[2], v[1], v[0]) * angle_unit_);
    const Eigen::Quaterniond quaternion(v[0], v[1], v[2], v[3]);
    if (!(quaternion.norm() > 0)) at.fail_expected("a quaternion that is not zero");
    return quaternion.normalized().toRotationMatrix();
  }

  Pose read_pose(const Entries& map) const {
    Pose pose;
    if (const SpecCursor* location = find_value(map, "location")) pose.p = plain_vector(*location);
    if (const SpecCursor* rotation = find_value(map, "orientation")) pose.R = orientation(*rotation);
    return pose;
  }

  void read_body(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a body");
    ForeignBody body;
    body.place = place_of(at);
    body.body.name = require_value(map, at, "name").read_word("a name");
    if (robot_.find_body(body.body.name) > 0)
      require_value(map, at, "name").fail({.expected = "another name", .found = "one that another body has"});
    require_value(map, at, "location");
    for (const char* key : {"contact", "visualization"})
      if (find_value(map, key) != nullptr) ++robot_.ignored[key];
    body.has_geometry = find_value(map, "visualization") != nullptr;
    const Pose pose = read_pose(map);
    const SpecCursor* fixed = find_value(map, "fixed");
    const bool is_fixed = fixed != nullptr && read_bool(*fixed);
    if (!is_fixed) read_mass(at, map, body);
    robot_.bodies.push_back(std::move(body));
    poses_.push_back(pose);
    if (is_fixed) fix(static_cast<int>(robot_.bodies.size()) - 1);
  }

  void fix(int index) {
    ForeignJoint joint;
    const Pose& pose = poses_[static_cast<std::size_t>(index)];
    joint.place = robot_.bodies[static_cast<std::size_t>(index)].place;
    joint.joint.name = robot_.bodies[static_cast<std::size_t>(index)].body.name + "_fixed";
    joint.joint.type = JointType::fixed;
    joint.joint.second = index;
    joint.joint.point_first = pose.p;
    joint.joint.rotation = pose.R;
    robot_.joints.push_back(std::move(joint));
  }

  void read_mass(const SpecCursor& at, const Entries& map, ForeignBody& body) {
    const SpecCursor& mass = require_value(map, at, "mass");
    body.has_inertial = true;
    body.body.mass = read_plain_number(mass);
    if (body.body.mass < 0)
      mass.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = mass.describe_found()});
    Pose com;
    if (const SpecCursor* frame = find_value(map, "com"))
      com = read_pose(read_mapping(*frame, "a frame {location, orientation}"));
    body.body.com = com.p;
    const SpecCursor* inertia = find_value(map, "inertia");
    if (inertia == nullptr) {
      if (body.body.mass > 0) at.fail_missing({"inertia"});
      return;
    }
    const Entries entries = read_mapping(*inertia, "an inertia {moments, products}");
    const auto moments = plain_vector(require_value(entries, *inertia, "moments"));
    const SpecCursor* products_value = find_value(entries, "products");
    const Vector3 products = products_value == nullptr ? Vector3(Vector3::Zero()) : plain_vector(*products_value);
    Matrix3 I;
    I << moments[0], products[0], products[1], products[0], moments[1], products[2], products[1], products[2],
        moments[2];
    I = com.R.isIdentity(0) ? I : Matrix3(com.R * I * com.R.transpose());
    body.body.inertia = 0.5 * (I + I.transpose());
  }

  int body_of(const Entries& map, const SpecCursor& at, const std::string& key) const {
    const SpecCursor& name_value = require_value(map, at, key);
    const std::string& name = name_value.read_word("a body's name");
    // the last body of that name: the file may call its own ground "ground", too
    for (std::size_t b = robot_.bodies.size(); b-- > 1;)
      if (robot_.bodies[b].body.name == name) return static_cast<int>(b);
    if (name == "ground") return 0;
    std::vector<std::string> names;
    for (const ForeignBody& body : robot_.bodies) names.push_back(body.body.name);
    name_value.fail({.expected = "a body", .found = quote_for_message(name), .hint = format_nearest_name(name, names)});
  }

  /// Creates a joint with the bodies and the position of a joint or motor, without its axes.
  ForeignJoint start_joint(const SpecCursor& at, const Entries& map) const {
    ForeignJoint foreign_joint;
    foreign_joint.place = place_of(at);
    foreign_joint.joint.name = require_value(map, at, "name").read_word("a name");
    if (robot_.find_joint(foreign_joint.joint.name) >= 0)
      require_value(map, at, "name").fail({.expected = "another name", .found = "one that another joint has"});
    foreign_joint.joint.first = body_of(map, at, "body1");
    foreign_joint.joint.second = body_of(map, at, "body2");
    if (foreign_joint.joint.first == foreign_joint.joint.second)
      require_value(map, at, "body2").fail({.expected = "two bodies", .found = "one"});
    const Vector3 position = plain_vector(require_value(map, at, "location"));
    const Pose &first = pose(foreign_joint.joint.first), &second = pose(foreign_joint.joint.second);
    foreign_joint.joint.point_first = first.R.transpose() * (position - first.p);
    foreign_joint.joint.point_second = second.R.transpose() * (position - second.p);
    foreign_joint.joint.rotation = first.R.transpose() * second.R;
    return foreign_joint;
  }

  const Pose& pose(int body) const { return poses_[static_cast<std::size_t>(body)]; }

  void read_joint(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a joint");
    ForeignJoint foreign_joint = start_joint(at, map);
    const Matrix3 to_first = pose(foreign_joint.joint.first).R.transpose();
    const std::string type = read_keyword(map, "type", "");
    const auto axis = [&](const char* key) { return Vector3(to_first * plain_direction(require_value(map, at, key))); };
    if (type == "REVOLUTE")
      foreign_joint.joint.type = JointType::revolute;
    else if (type == "PRISMATIC")
      foreign_joint.joint.type = JointType::prismatic;
    else if (type == "CYLINDRICAL")
      foreign_joint.joint.type = JointType::cylindrical;
    else if (type == "SPHERICAL")
      foreign_joint.joint.type = JointType::spherical;
    else if (type == "UNIVERSAL")
      foreign_joint.joint.type = JointType::universal;
    else if (type == "LOCK" || type == "FIXED")
      foreign_joint.joint.type = JointType::fixed;
    else
      require_value(map, at, "type")
          .fail({.expected = "LOCK, REVOLUTE, PRISMATIC, CYLINDRICAL, SPHERICAL or UNIVERSAL",
                 .found = quote_for_message(type)});
    if (type == "REVOLUTE" || type == "PRISMATIC" || type == "CYLINDRICAL") foreign_joint.joint.axis = axis("axis");
    if (type == "UNIVERSAL") {
      foreign_joint.joint.axis = axis("axis1");
      foreign_joint.joint.axis2 = axis("axis2");
      if (std::abs(foreign_joint.joint.axis.dot(foreign_joint.joint.axis2)) > 1e-9)
        require_value(map, at, "axis2").fail_expected("a direction perpendicular to 'axis1'");
      foreign_joint.joint.axis2 = (foreign_joint.joint.axis2 -
                                   foreign_joint.joint.axis.dot(foreign_joint.joint.axis2) * foreign_joint.joint.axis)
                                      .normalized();
    }
    if (find_value(map, "bushing_data") != nullptr)
      add_finding(Severity::warning, at, "bushing",
                  fmt::format("joint {}", quote_for_message(foreign_joint.joint.name)),
                  "is a bushing: taken as an ideal joint");
    robot_.joints.push_back(std::move(foreign_joint));
  }

  /// A motor that also guides becomes a joint; a free one drives the joint between its bodies.
  void read_motor(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a motor");
    ForeignJoint foreign_joint = start_joint(at, map);
    const std::string type = read_keyword(map, "type", "");
    const bool is_rotary = type == "ROTATION";
    if (!is_rotary && type != "LINEAR")
      require_value(map, at, "type").fail({.expected = "LINEAR or ROTATION", .found = quote_for_message(type)});
    const char* key = is_rotary ? "spindle" : "guide";
    const std::string guidance = read_keyword(map, key, is_rotary ? "REVOLUTE" : "PRISMATIC");
    foreign_joint.joint.type = is_rotary ? JointType::revolute : JointType::prismatic;
    foreign_joint.joint.axis =
        pose(foreign_joint.joint.first).R.transpose() * plain_direction(require_value(map, at, "axis"));
    foreign_joint.is_actuated = robot_.declares_actuators = true;
    if (guidance == (is_rotary ? "REVOLUTE" : "PRISMATIC")) return robot_.joints.push_back(std::move(foreign_joint));
    if (guidance != "FREE")
      find_value(map, key)->fail(
          {.expected = is_rotary ? "REVOLUTE or FREE" : "PRISMATIC or FREE", .found = quote_for_message(guidance)});
    for (ForeignJoint& joint : robot_.joints) {
      const auto connects = [&](int a, int b) { return joint.joint.first == a && joint.joint.second == b; };
      const bool connects_same_bodies = connects(foreign_joint.joint.first, foreign_joint.joint.second) ||
                                        connects(foreign_joint.joint.second, foreign_joint.joint.first);
      if (!connects_same_bodies ||
          (joint.joint.type != foreign_joint.joint.type && joint.joint.type != JointType::cylindrical))
        continue;
      joint.is_actuated = true;
      if (joint.joint.type == JointType::cylindrical) joint.actuated_coordinate = is_rotary ? "angle" : "slide";
      add_finding(Severity::note, at, "motor", fmt::format("motor {}", quote_for_message(foreign_joint.joint.name)),
                  fmt::format("drives joint {}", quote_for_message(joint.joint.name)));
      return;
    }
    at.fail({.expected = "a joint between its bodies that it can drive", .found = "none"});
  }

  void read_spring(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a spring");
    ForeignSpring spring;
    spring.name = require_value(map, at, "name").read_word("a name");
    const std::string subject = fmt::format("spring {}", quote_for_message(spring.name));
    for (const char* key : {"spring_curve_data", "damping_curve_data", "map_data"})
      if (find_value(map, key) != nullptr)
        return add_finding(Severity::warning, at, "left-out", subject, "is not linear: left out");
    spring.first = body_of(map, at, "body1");
    spring.second = body_of(map, at, "body2");
    const auto local_point = [&](int body, const char* key) {
      return Vector3(pose(body).R.transpose() * (plain_vector(require_value(map, at, key)) - pose(body).p));
    };
    spring.point_first = local_point(spring.first, "point1");
    spring.point_second = local_point(spring.second, "point2");
    const auto number = [&](const char* key) {
      return find_value(map, key) == nullptr ? 0 : read_plain_number(*find_value(map, key));
    };
    spring.stiffness = number("spring_coefficient");
    spring.free_length = number("free_length");
    if (spring.stiffness < 0 || spring.free_length < 0)
      at.fail_expected("a spring with spring_coefficient and free_length ≥ 0");
    spring.damping = number("damping_coefficient");
    if (spring.damping < 0) at.fail_expected("a damping_coefficient ≥ 0");
    if (number("preload") != 0) add_finding(Severity::warning, at, "preload", subject, "its preload is left out");
    if (spring.first != spring.second && (spring.stiffness > 0 || spring.damping > 0))
      robot_.springs.push_back(std::move(spring));
  }

  std::string file_;
  ForeignModel robot_;
  std::vector<Pose> poses_;  ///< of bodies in the world frame
  double angle_unit_ = std::numbers::pi / 180;
};

}  // namespace

ForeignModel read_chrono(const SpecCursor& root, const std::string& file) { return ChronoReader(file).run(root); }

}  // namespace balance::foreign
