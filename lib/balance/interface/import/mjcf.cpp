#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/mjcf_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace balance::foreign {

// What MJCF says between bodies and joints that exist: closures, couplings, motors.

/// `<equality>` (connect, weld, joint) and `<actuator>`.
void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                         ForeignModel& robot);

namespace {

/// Where bodies are being read: below which body, at what pose in it, with which class.
struct BodyContext {
  int parent = 0;
  Pose frame;
  std::string child_class;
};

class MjcfReader {
 public:
  explicit MjcfReader(const XmlDocument& document)
      : tree_(expand_mjcf_includes(document)),
        read_(faults_),
        defaults_(tree_.root, faults_),
        angles_(tree_.root, read_, faults_),
        geoms_(tree_.root, read_, defaults_, angles_) {
    robot_.format = "MJCF";
    robot_.file = document.file;
  }

  ForeignModel run() {
    const std::string* model = tree_.root.attribute("model");
    robot_.name = model == nullptr ? "" : *model;
    ForeignBody world;
    world.body.name = "world";
    world.place = place_of(tree_.root);
    robot_.bodies.push_back(std::move(world));
    for (const XmlElement& part : tree_.root.children) read_section(part);
    faults_.throw_if_any();
    read_mjcf_relations(tree_.root, defaults_, faults_, robot_);
    faults_.throw_if_any();
    return std::move(robot_);
  }

 private:
  void note(Severity level, const XmlElement& at, const char* code, const std::string& subject,
            const std::string& message) {
    robot_.findings.push_back({level, place_of(at), code, subject, message});
  }

  void read_section(const XmlElement& part) {
    if (part.name == "worldbody") return read_children(part, {});
    if (part.name == "option") robot_.gravity = read_.vector(part, "gravity", robot_.gravity);
    if (part.name == "compiler") read_compiler(part);
    if (is_one_of(part.name, {"option", "compiler", "default", "equality", "actuator"})) return;
    robot_.ignored[part.name] += std::max<int>(1, static_cast<int>(part.children.size()));
  }

  void read_compiler(const XmlElement& at) {
    const auto is = [&](const char* name, const char* value) {
      const std::string* said = at.attribute(name);
      return said != nullptr && *said == value;
    };
    if (is("coordinate", "global"))
      read_.report(at, "coordinate", "expected local coordinates: save the model with MuJoCo first");
    for (const char* change : {"settotalmass", "boundmass", "boundinertia", "balanceinertia"})
      if (at.attribute(change) != nullptr && !is(change, "false") && !is(change, "-1") && !is(change, "0"))
        note(Severity::warning, at, "compiler", "compiler",
             fmt::format("{} changes masses when MuJoCo loads the file; here it does not", change));
  }

  /// Bodies, and frames that only turn and shift what is in them.
  void read_children(const XmlElement& parent, const BodyContext& branch) {
    for (const XmlElement& child : parent.children) {
      if (child.name == "body") {
        read_body(child, branch);
      } else if (child.name == "frame") {
        BodyContext inner = branch;
        inner.frame = branch.frame * pose_of(child);
        if (const std::string* name = child.attribute("childclass")) inner.child_class = *name;
        read_children(child, inner);
      } else if (is_one_of(child.name, {"replicate", "composite", "flexcomp", "attach"})) {
        read_.report(
            child, "",
            fmt::format(
                "expected bodies, found <{}>: save the model with MuJoCo (mj_saveLastXML), which writes them out",
                child.name));
      } else if (!is_one_of(child.name, {"inertial", "joint", "freejoint"})) {
        ++robot_.ignored[child.name];
      }
    }
  }

  Pose pose_of(const XmlElement& at) { return {angles_.orientation(at), read_.vector(at, "pos", Vector3::Zero())}; }

  void read_body(const XmlElement& element, const BodyContext& branch) {
    if (robot_.bodies.size() > max_model_elements) {
      read_.report(element, "", "expected at most 2000 bodies");
      faults_.throw_if_any();
    }
    const std::string* given = element.attribute("name");
    ForeignBody body;
    body.body.name = given != nullptr ? *given : fmt::format("body{}", robot_.bodies.size());
    body.place = place_of(element);
    if (robot_.find_body(body.body.name) >= 0)
      read_.report(element, "name", "expected another name: there is a body of this one already");
    BodyContext inner = branch;
    inner.frame = {};
    if (const std::string* name = element.attribute("childclass")) inner.child_class = *name;
    std::vector<const XmlElement*> joints;
    for (const XmlElement& child : element.children) {
      if (child.name == "inertial") read_inertial(child, body);
      if (child.name == "joint" || child.name == "freejoint") joints.push_back(&child);
      if (child.name == "geom") body.has_geometry = true;
    }
    const Pose pose = branch.frame * pose_of(element);
    if (geoms_.overrides_inertial() || (geoms_.is_used() && !body.has_inertial))
      weigh_geoms(element, inner, body, !joints.empty());
    inner.parent = add_chain(element, joints, branch.parent, pose, std::move(body), inner.child_class);
    read_children(element, inner);
  }

  void read_inertial(const XmlElement& at, ForeignBody& body) {
    body.has_inertial = true;
    body.body.com = read_.vector(at, "pos", Vector3::Zero());
    body.body.mass = read_.number(at, "mass", 0);
    if (at.attribute("mass") == nullptr || body.body.mass < 0) read_.report(at, "mass", "expected a mass ≥ 0");
    const Matrix3 R = angles_.orientation(at);
    Matrix3 I = Matrix3::Zero();
    if (const auto d = read_.numbers(at, "diaginertia", {3}); !d.empty()) I.diagonal() << d[0], d[1], d[2];
    if (const auto f = read_.numbers(at, "fullinertia", {6}); !f.empty())
      I << f[0], f[3], f[4], f[3], f[1], f[5], f[4], f[5], f[2];
    I = R.isIdentity(0) ? I : Matrix3(R * I * R.transpose());
    body.body.inertia = 0.5 * (I + I.transpose());
  }

  /// A body's mass may follow from its shapes.
  void weigh_geoms(const XmlElement& element, const BodyContext& branch, ForeignBody& body, bool moves) {
    const GeomInertia found = geoms_.compute(element, branch.child_class);
    const std::string subject = fmt::format("body {}", quote_for_message(body.body.name));
    if (!found.unsupported_shape.empty()) {
      body.has_unknown_mass = true;
      if (moves)
        read_.report(
            element, "",
            fmt::format("expected <inertial>: its mass follows from {}, which is not read; save the model with "
                        "MuJoCo (mj_saveLastXML), which writes it",
                        found.unsupported_shape));
      return;
    }
    if (found.geoms == 0) return;
    body.has_inertial = true;
    body.body.mass = found.mass;
    body.body.com = found.com;
    body.body.inertia = found.inertia;
    note(Severity::note, element, "geoms", subject,
         fmt::format("its mass of {:.6g} kg follows from {} geom{}", found.mass, found.geoms,
                     found.geoms == 1 ? "" : "s"));
  }

  /// Each joint carries what comes after it; all but the last carry nothing else. @return the body's index
  int add_chain(const XmlElement& element, const std::vector<const XmlElement*>& joints, int parent, const Pose& pose,
                ForeignBody body, const std::string& child_class) {
    const std::string name = body.body.name;
    if (joints.empty()) {
      const int index = add_body(std::move(body));
      ForeignJoint weld;
      weld.joint.name = name + "_weld";
      weld.place = place_of(element);
      weld.joint.type = JointType::fixed;
      connect_bodies(weld, parent, index, pose, Vector3::Zero());
      return index;
    }
    for (std::size_t k = 0; k < joints.size(); ++k) {
      ForeignBody carried;
      carried.body.name = fmt::format("{}_before_{}", name, k + 2);
      carried.place = place_of(*joints[k]);
      if (k + 1 == joints.size()) std::swap(carried, body);
      const int index = add_body(std::move(carried));
      read_joint(*joints[k], name, k, parent, index, k == 0 ? pose : Pose{}, child_class);
      parent = index;
    }
    return parent;
  }

  int add_body(ForeignBody body) {
    robot_.bodies.push_back(std::move(body));
    return static_cast<int>(robot_.bodies.size()) - 1;
  }

  /// @param place of the joint, in the second body's frame
  void connect_bodies(ForeignJoint& one, int first, int second, const Pose& pose, const Vector3& place) {
    one.joint.first = first;
    one.joint.second = second;
    one.joint.point_first = pose.p + pose.R * place;
    one.joint.point_second = place;
    one.joint.rotation = pose.R;
    robot_.joints.push_back(one);
  }

  void read_joint(const XmlElement& element, const std::string& body, std::size_t k, int first, int second,
                  const Pose& pose, const std::string& child_class) {
    const XmlElement full = element.name == "freejoint" ? element : defaults_.apply(element, child_class);
    const std::string *name = element.attribute("name"), *type = full.attribute("type");
    ForeignJoint one;
    one.joint.name = name != nullptr ? *name : k == 0 ? body + "_joint" : fmt::format("{}_joint{}", body, k + 1);
    one.place = place_of(element);
    if (robot_.find_joint(one.joint.name) >= 0)
      read_.report(element, "name", "expected another name: there is a joint of this one already");
    const std::string kind = element.name == "freejoint" ? "free" : type == nullptr ? "hinge" : *type;
    if (kind == "hinge")
      one.joint.type = JointType::revolute;
    else if (kind == "slide")
      one.joint.type = JointType::prismatic;
    else if (kind == "ball")
      one.joint.type = JointType::spherical;
    else if (kind == "free") {
      one.joint.type = JointType::fixed;
      one.is_floating = true;
    } else
      read_.report(element, "type",
                   fmt::format("expected hinge, slide, ball or free, found {}", quote_for_message(kind)));
    const Vector3 axis = read_.vector(full, "axis", Vector3::UnitZ());
    if (!(axis.norm() > 1e-100 && axis.norm() < 1e100))
      read_.report(element, "axis", "expected a direction, found a vector without length");
    one.joint.axis = pose.R * axis.normalized();
    read_dynamics(full, kind == "slide" ? 1 : angles_.unit(), one);
    connect_bodies(one, first, second, pose, read_.vector(full, "pos", Vector3::Zero()));
  }

  void read_dynamics(const XmlElement& full, double unit, ForeignJoint& one) {
    const double ref = read_.number(full, "ref", 0) * unit;
    if (ref != 0) one.note = fmt::format("the file's coordinate less its ref of {}", ref);
    if (const auto range = read_.numbers(full, "range", {2}); !range.empty())
      one.limits = {range[0] * unit - ref, range[1] * unit - ref, {}, {}};
    if (one.joint.type == JointType::fixed || one.joint.type == JointType::spherical) return;
    one.armature = read_.number(full, "armature", 0);
    if (!(one.armature >= 0)) read_.report(full, "armature", "expected an armature ≥ 0");
    one.viscous = read_.number(full, "damping", 0);
    one.coulomb = read_.number(full, "frictionloss", 0);
    if (one.viscous < 0 || one.coulomb < 0) read_.report(full, "", "damping and friction cannot be negative");
    if (one.viscous != 0 || one.coulomb != 0)
      note(Severity::note, full, "friction", fmt::format("joint {}", quote_for_message(one.joint.name)),
           fmt::format("damping {:g} and friction {:g} are in 'friction'", one.viscous, one.coulomb));
    one.stiffness = read_.number(full, "stiffness", 0);
    if (one.stiffness < 0) read_.report(full, "stiffness", "expected a stiffness ≥ 0");
    one.spring_reference = read_.number(full, "springref", 0) * unit - ref;
    if (one.stiffness != 0)
      note(Severity::note, full, "spring", fmt::format("joint {}", quote_for_message(one.joint.name)),
           fmt::format("its stiffness of {:g} is in 'springs'", one.stiffness));
    if (one.armature != 0)
      note(Severity::note, full, "armature", fmt::format("joint {}", quote_for_message(one.joint.name)),
           fmt::format("its armature of {:g} is offered as a disc in a comment", one.armature));
  }

  ExpandedMjcf tree_;
  ForeignDiagnostics faults_;
  XmlAttributeReader read_;
  MjcfDefaults defaults_;
  MjcfCompilerAngles angles_;
  MjcfGeomInertia geoms_;
  ForeignModel robot_;
};

}  // namespace

ForeignModel read_mjcf(const XmlDocument& document) { return MjcfReader(document).run(); }

namespace {

class MjcfRelationReader {
 public:
  MjcfRelationReader(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                     ForeignModel& robot)
      : root_(root), defaults_(defaults), read_(faults), robot_(robot) {}

  void run() {
    poses_ = zero_configuration_poses(robot_);
    collect_sites(root_, "world");
    for (const XmlElement& section : root_.children) {
      if (section.name == "equality")
        for (const XmlElement& one : section.children) read_equality(defaults_.apply(one, ""));
      if (section.name == "actuator")
        for (const XmlElement& one : section.children) read_actuator(one);
    }
  }

 private:
  struct Site {
    std::string body;
    Vector3 position;
  };

  /// Sites are places; those inside a <frame> are not known.
  void collect_sites(const XmlElement& element, const std::string& body) {
    for (const XmlElement& child : element.children) {
      if (child.name == "site")
        if (const std::string* name = child.attribute("name"))
          sites_[*name] = {body, read_.vector(child, "pos", Vector3::Zero())};
      const std::string* name = child.name == "body" ? child.attribute("name") : nullptr;
      if (child.name == "worldbody" || child.name == "body") collect_sites(child, name != nullptr ? *name : body);
    }
  }

  int find_body(const XmlElement& at, const char* attribute) {
    const std::string* name = at.attribute(attribute);
    if (name == nullptr) return 0;  // the world
    const int found = robot_.find_body(*name);
    if (found < 0) read_.report(at, attribute, fmt::format("there is no body {}", quote_for_message(*name)));
    return found;
  }

  std::string name_of(const XmlElement& at, const char* fallback) {
    const std::string* name = at.attribute("name");
    return name != nullptr ? *name : fmt::format("{}{}", fallback, ++unnamed_);
  }

  void read_equality(const XmlElement& at) {
    const std::string* active = at.attribute("active");
    if (active != nullptr && *active == "false") {
      ++robot_.ignored["inactive equality"];
    } else if (at.name == "connect") {
      read_connect(at);
    } else if (at.name == "weld") {
      read_weld(at);
    } else if (at.name == "joint") {
      read_coupling(at);
    } else {
      ++robot_.ignored["equality " + at.name];
      robot_.findings.push_back({Severity::warning, place_of(at), "equality", "equality " + at.name, "is left out"});
    }
  }

  Pose between(int first, int second) const {
    return poses_[static_cast<std::size_t>(first)].inverse() * poses_[static_cast<std::size_t>(second)];
  }

  /// The place in the second body follows from the model's pose; two sites are said on both.
  void read_connect(const XmlElement& at) {
    if (at.attribute("site1") != nullptr) return read_site_connect(at);
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (at.attribute("anchor") == nullptr) return read_.report(at, "", "expected anchor=\"x y z\"");
    if (first == second) return read_.report(at, "", "expected two bodies, found one");
    const Vector3 anchor = read_.vector(at, "anchor", Vector3::Zero());
    const Pose back = between(second, first);
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, {first, {Matrix3::Identity(), anchor}},
                   {second, {back.R, back.p + back.R * anchor}}, Vector3::UnitZ(), place_of(at));
  }

  void read_site_connect(const XmlElement& at) {
    const auto end = [&](const char* attribute) -> std::optional<BodyFrame> {
      const std::string* name = at.attribute(attribute);
      const auto found = name == nullptr ? sites_.end() : sites_.find(*name);
      const int body = found == sites_.end() ? -1 : robot_.find_body(found->second.body);
      if (body < 0) {
        read_.report(at, attribute, "expected the name of a site of a body that has a name");
        return {};
      }
      return BodyFrame{body, {Matrix3::Identity(), found->second.position}};
    };
    const auto first = end("site1"), second = end("site2");
    if (!first || !second) return;
    if (first->body == second->body) return read_.report(at, "", "expected two bodies, found one");
    BodyFrame turned = *second;
    turned.pose.R = between(second->body, first->body).R;
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, *first, turned, Vector3::UnitZ(),
                   place_of(at));
  }

  void read_weld(const XmlElement& at) {
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (first == second) return read_.report(at, "", "expected two bodies, found one");
    Pose pose = between(first, second);
    if (const auto v = read_.numbers(at, "relpose", {7}); !v.empty()) {
      const Eigen::Quaterniond turn(v[3], v[4], v[5], v[6]);
      if (turn.norm() > 0) pose = {turn.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
    }
    add_loop_joint(robot_, name_of(at, "weld"), JointType::fixed, {first, pose}, {second, {}}, Vector3::UnitZ(),
                   place_of(at));
  }

  int find_joint(const XmlElement& at, const char* attribute) {
    const std::string name = read_.required_text(at, attribute);
    const int found = name.empty() ? -1 : robot_.find_joint(name);
    if (!name.empty() &&
        (found < 0 || joint_degrees_of_freedom(robot_.joints[static_cast<std::size_t>(found)].joint.type) != 1)) {
      read_.report(at, attribute, fmt::format("expected a hinge or slide, found {}", quote_for_message(name)));
      return -1;
    }
    return found;
  }

  /// q1 − ref1 = c0 + c1 (q2 − ref2) + …; without joint2 q1 stands still.
  void read_coupling(const XmlElement& at) {
    const int follower = find_joint(at, "joint1");
    auto c = read_.numbers(at, "polycoef", {1, 2, 3, 4, 5});
    if (c.empty()) c = {0, 1};
    c.resize(5);
    if (follower < 0) return;
    if (at.attribute("joint2") == nullptr)
      return read_.report(at, "joint2", "expected a second joint: a joint that stands still is a body without one");
    const int leader = find_joint(at, "joint2");
    if (leader < 0) return;
    if (c[2] != 0 || c[3] != 0 || c[4] != 0 || c[1] == 0 || leader == follower)
      return read_.report(at, "polycoef", "expected a linear relation between two joints");
    robot_.couplings.push_back({follower, leader, c[1], c[0], place_of(at)});
  }

  void read_actuator(const XmlElement& at) {
    const std::string* name = at.attribute("joint");
    if (name == nullptr) name = at.attribute("jointinparent");
    if (name == nullptr) {
      ++robot_.ignored["actuator without a joint"];
      return;
    }
    const int found = robot_.find_joint(*name);
    if (found < 0) return read_.report(at, "joint", fmt::format("there is no joint {}", quote_for_message(*name)));
    robot_.joints[static_cast<std::size_t>(found)].is_actuated = robot_.declares_actuators = true;
  }

  const XmlElement& root_;
  const MjcfDefaults& defaults_;
  XmlAttributeReader read_;
  ForeignModel& robot_;
  std::vector<Pose> poses_;
  std::map<std::string, Site> sites_;
  int unnamed_ = 0;
};

}  // namespace

void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& faults,
                         ForeignModel& robot) {
  MjcfRelationReader(root, defaults, faults, robot).run();
}

}  // namespace balance::foreign
