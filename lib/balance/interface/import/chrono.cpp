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

const SpecCursor* find(const Entries& map, const std::string& key) {
  const auto found = map.find(key);
  return found == map.end() ? nullptr : &found->second;
}

const SpecCursor& need(const Entries& map, const SpecCursor& at, const std::string& key) {
  const SpecCursor* found = find(map, key);
  if (found == nullptr) at.fail_missing({key});
  return *found;
}

/// Words may be written in any case, with `_` or `-`.
std::string word_of(const Entries& map, const std::string& key, const std::string& fallback) {
  const SpecCursor* at = find(map, key);
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
    const Entries top = read_mapping(root, "a Chrono model");
    const SpecCursor& at = need(top, root, "model");
    const Entries model = read_mapping(at, "a model");
    if (const SpecCursor* name = find(model, "name")) robot_.name = name->read_word("a name");
    if (const SpecCursor* degrees = find(model, "angle_degrees"))
      unit_ = read_bool(*degrees) ? std::numbers::pi / 180 : 1;
    each(need(model, at, "bodies"), "a list of bodies", &ChronoReader::read_body);
    root.problems().throw_if_any();
    for (const auto& [key, read] : {std::pair{"joints", &ChronoReader::read_joint},
                                    {"motors", &ChronoReader::read_motor},
                                    {"tsdas", &ChronoReader::read_spring}})
      if (const SpecCursor* list = find(model, key)) each(*list, std::string("a list of ") + key, read);
    refuse_others(model);
    root.problems().throw_if_any();
    note(Severity::note, root, "gravity", "gravity", "is no part of the model: (0, 0, -9.81) is taken");
    return std::move(robot_);
  }

 private:
  using Reader = void (ChronoReader::*)(const SpecCursor&);

  void each(const SpecCursor& list, const std::string& what, Reader read) {
    list.problems().collect([&] {
      const auto items = list.items(what);
      if (items.size() > 2000) list.fail_expected("at most 2000 entries");
      specification::read_each(items, [&](const SpecCursor& at) { (this->*read)(at); });
    });
  }

  SourceLocation place_of(const SpecCursor& at) const {
    return {file_, at.node().place.line, at.node().place.column, ""};
  }

  void note(Severity level, const SpecCursor& at, const char* code, const std::string& subject,
            const std::string& message) {
    robot_.findings.push_back({level, place_of(at), code, subject, message});
  }

  void refuse_others(const Entries& model) {
    if (const SpecCursor* constraints = find(model, "constraints");
        constraints != nullptr && !constraints->node().items.empty())
      constraints->problems().collect(
          [&] { constraints->fail_expected("joints only: constraints between points are not read"); });
    for (const char* key : {"rsdas", "body_loads", "load_controllers"})
      if (const SpecCursor* list = find(model, key); list != nullptr && !list->node().items.empty())
        note(Severity::warning, *list, "left-out", key, fmt::format("{} of them left out", list->node().items.size()));
  }

  Matrix3 orientation(const SpecCursor& at) const {
    const auto v = plain_numbers(at, "[yaw, pitch, roll] or a quaternion", {3, 4});
    if (v.size() == 3) return rotation_from_rpy(Vector3(v[2], v[1], v[0]) * unit_);
    const Eigen::Quaterniond turn(v[0], v[1], v[2], v[3]);
    if (!(turn.norm() > 0)) at.fail_expected("a quaternion that is not zero");
    return turn.normalized().toRotationMatrix();
  }

  Pose read_pose(const Entries& map) const {
    Pose pose;
    if (const SpecCursor* location = find(map, "location")) pose.p = plain_vector(*location);
    if (const SpecCursor* turned = find(map, "orientation")) pose.R = orientation(*turned);
    return pose;
  }

  void read_body(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a body");
    ForeignBody body;
    body.place = place_of(at);
    body.body.name = need(map, at, "name").read_word("a name");
    if (robot_.find_body(body.body.name) > 0)
      need(map, at, "name").fail({.expected = "another name", .found = "one that another body has"});
    need(map, at, "location");
    for (const char* key : {"contact", "visualization"})
      if (find(map, key) != nullptr) ++robot_.ignored[key];
    body.has_geometry = find(map, "visualization") != nullptr;
    const Pose pose = read_pose(map);
    const SpecCursor* fixed = find(map, "fixed");
    const bool stands = fixed != nullptr && read_bool(*fixed);
    if (!stands) read_mass(at, map, body);
    robot_.bodies.push_back(std::move(body));
    poses_.push_back(pose);
    if (stands) fix(static_cast<int>(robot_.bodies.size()) - 1);
  }

  void fix(int index) {
    ForeignJoint weld;
    const Pose& pose = poses_[static_cast<std::size_t>(index)];
    weld.place = robot_.bodies[static_cast<std::size_t>(index)].place;
    weld.joint.name = robot_.bodies[static_cast<std::size_t>(index)].body.name + "_fixed";
    weld.joint.type = JointType::fixed;
    weld.joint.second = index;
    weld.joint.point_first = pose.p;
    weld.joint.rotation = pose.R;
    robot_.joints.push_back(std::move(weld));
  }

  void read_mass(const SpecCursor& at, const Entries& map, ForeignBody& body) {
    const SpecCursor& mass = need(map, at, "mass");
    body.has_inertial = true;
    body.body.mass = read_plain_number(mass);
    if (body.body.mass < 0)
      mass.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = mass.describe_found()});
    Pose com;
    if (const SpecCursor* frame = find(map, "com"))
      com = read_pose(read_mapping(*frame, "a frame {location, orientation}"));
    body.body.com = com.p;
    const SpecCursor* inertia = find(map, "inertia");
    if (inertia == nullptr) {
      if (body.body.mass > 0) at.fail_missing({"inertia"});
      return;
    }
    const Entries parts = read_mapping(*inertia, "an inertia {moments, products}");
    const auto moments = plain_vector(need(parts, *inertia, "moments"));
    const SpecCursor* said = find(parts, "products");
    const Vector3 products = said == nullptr ? Vector3(Vector3::Zero()) : plain_vector(*said);
    Matrix3 I;
    I << moments[0], products[0], products[1], products[0], moments[1], products[2], products[1], products[2],
        moments[2];
    I = com.R.isIdentity(0) ? I : Matrix3(com.R * I * com.R.transpose());
    body.body.inertia = 0.5 * (I + I.transpose());
  }

  int body_of(const Entries& map, const SpecCursor& at, const std::string& key) const {
    const SpecCursor& named = need(map, at, key);
    const std::string& name = named.read_word("a body's name");
    // the last of that name: the ground of the file may be called so, too
    for (std::size_t b = robot_.bodies.size(); b-- > 1;)
      if (robot_.bodies[b].body.name == name) return static_cast<int>(b);
    if (name == "ground") return 0;
    std::vector<std::string> names;
    for (const ForeignBody& body : robot_.bodies) names.push_back(body.body.name);
    named.fail({.expected = "a body", .found = quote_for_message(name), .hint = format_nearest_name(name, names)});
  }

  /// The bodies of a joint or motor and where it is, without its axes.
  ForeignJoint start_joint(const SpecCursor& at, const Entries& map) const {
    ForeignJoint one;
    one.place = place_of(at);
    one.joint.name = need(map, at, "name").read_word("a name");
    if (robot_.find_joint(one.joint.name) >= 0)
      need(map, at, "name").fail({.expected = "another name", .found = "one that another joint has"});
    one.joint.first = body_of(map, at, "body1");
    one.joint.second = body_of(map, at, "body2");
    if (one.joint.first == one.joint.second) need(map, at, "body2").fail({.expected = "two bodies", .found = "one"});
    const Vector3 place = plain_vector(need(map, at, "location"));
    const Pose &first = pose(one.joint.first), &second = pose(one.joint.second);
    one.joint.point_first = first.R.transpose() * (place - first.p);
    one.joint.point_second = second.R.transpose() * (place - second.p);
    one.joint.rotation = first.R.transpose() * second.R;
    return one;
  }

  const Pose& pose(int body) const { return poses_[static_cast<std::size_t>(body)]; }

  void read_joint(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a joint");
    ForeignJoint one = start_joint(at, map);
    const Matrix3 to_first = pose(one.joint.first).R.transpose();
    const std::string type = word_of(map, "type", "");
    const auto axis = [&](const char* key) { return Vector3(to_first * plain_direction(need(map, at, key))); };
    if (type == "REVOLUTE")
      one.joint.type = JointType::revolute;
    else if (type == "PRISMATIC")
      one.joint.type = JointType::prismatic;
    else if (type == "CYLINDRICAL")
      one.joint.type = JointType::cylindrical;
    else if (type == "SPHERICAL")
      one.joint.type = JointType::spherical;
    else if (type == "UNIVERSAL")
      one.joint.type = JointType::universal;
    else if (type == "LOCK" || type == "FIXED")
      one.joint.type = JointType::fixed;
    else
      need(map, at, "type")
          .fail({.expected = "LOCK, REVOLUTE, PRISMATIC, CYLINDRICAL, SPHERICAL or UNIVERSAL",
                 .found = quote_for_message(type)});
    if (type == "REVOLUTE" || type == "PRISMATIC" || type == "CYLINDRICAL") one.joint.axis = axis("axis");
    if (type == "UNIVERSAL") {
      one.joint.axis = axis("axis1");
      one.joint.axis2 = axis("axis2");
      if (std::abs(one.joint.axis.dot(one.joint.axis2)) > 1e-9)
        need(map, at, "axis2").fail_expected("a direction at a right angle to 'axis1'");
      one.joint.axis2 = (one.joint.axis2 - one.joint.axis.dot(one.joint.axis2) * one.joint.axis).normalized();
    }
    if (find(map, "bushing_data") != nullptr)
      note(Severity::warning, at, "bushing", fmt::format("joint {}", quote_for_message(one.joint.name)),
           "is a bushing: taken as an ideal joint");
    robot_.joints.push_back(std::move(one));
  }

  /// A motor that guides is a joint; one that does not drives the joint between its bodies.
  void read_motor(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a motor");
    ForeignJoint one = start_joint(at, map);
    const std::string type = word_of(map, "type", "");
    const bool turns = type == "ROTATION";
    if (!turns && type != "LINEAR")
      need(map, at, "type").fail({.expected = "LINEAR or ROTATION", .found = quote_for_message(type)});
    const char* key = turns ? "spindle" : "guide";
    const std::string way = word_of(map, key, turns ? "REVOLUTE" : "PRISMATIC");
    one.joint.type = turns ? JointType::revolute : JointType::prismatic;
    one.joint.axis = pose(one.joint.first).R.transpose() * plain_direction(need(map, at, "axis"));
    one.is_actuated = robot_.declares_actuators = true;
    if (way == (turns ? "REVOLUTE" : "PRISMATIC")) return robot_.joints.push_back(std::move(one));
    if (way != "FREE")
      find(map, key)->fail(
          {.expected = turns ? "REVOLUTE or FREE" : "PRISMATIC or FREE", .found = quote_for_message(way)});
    for (ForeignJoint& joint : robot_.joints) {
      const auto same = [&](int a, int b) { return joint.joint.first == a && joint.joint.second == b; };
      const bool between = same(one.joint.first, one.joint.second) || same(one.joint.second, one.joint.first);
      if (!between || (joint.joint.type != one.joint.type && joint.joint.type != JointType::cylindrical)) continue;
      joint.is_actuated = true;
      if (joint.joint.type == JointType::cylindrical) joint.actuated_coordinate = turns ? "angle" : "slide";
      note(Severity::note, at, "motor", fmt::format("motor {}", quote_for_message(one.joint.name)),
           fmt::format("drives joint {}", quote_for_message(joint.joint.name)));
      return;
    }
    at.fail({.expected = "a joint between its bodies that it can drive", .found = "none"});
  }

  void read_spring(const SpecCursor& at) {
    const Entries map = read_mapping(at, "a spring");
    Spring spring;
    spring.name = need(map, at, "name").read_word("a name");
    const std::string subject = fmt::format("spring {}", quote_for_message(spring.name));
    for (const char* key : {"spring_curve_data", "damping_curve_data", "map_data"})
      if (find(map, key) != nullptr) return note(Severity::warning, at, "left-out", subject, "is not linear: left out");
    spring.first = body_of(map, at, "body1");
    spring.second = body_of(map, at, "body2");
    const auto place = [&](int body, const char* key) {
      return Vector3(pose(body).R.transpose() * (plain_vector(need(map, at, key)) - pose(body).p));
    };
    spring.point_first = place(spring.first, "point1");
    spring.point_second = place(spring.second, "point2");
    const auto number = [&](const char* key) {
      return find(map, key) == nullptr ? 0 : read_plain_number(*find(map, key));
    };
    spring.stiffness = number("spring_coefficient");
    spring.free_length = number("free_length");
    if (spring.stiffness < 0 || spring.free_length < 0)
      at.fail_expected("a spring with spring_coefficient and free_length ≥ 0");
    if (number("damping_coefficient") != 0) note(Severity::warning, at, "damper", subject, "its damping is left out");
    if (number("preload") != 0) note(Severity::warning, at, "preload", subject, "its preload is left out");
    if (spring.first != spring.second && spring.stiffness > 0) robot_.springs.push_back(std::move(spring));
  }

  std::string file_;
  ForeignModel robot_;
  std::vector<Pose> poses_;  ///< of bodies in the world
  double unit_ = std::numbers::pi / 180;
};

}  // namespace

ForeignModel read_chrono(const SpecCursor& root, const std::string& file) { return ChronoReader(file).run(root); }

}  // namespace balance::foreign
