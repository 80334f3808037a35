#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/mjcf_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

namespace balance::foreign {

// Relations between existing bodies and joints in an MJCF: closures, couplings, motors.

/// Reads `<equality>` (connect, weld, joint), `<tendon>` (springs and dampers between two sites) and `<actuator>`.
void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& diagnostics,
                         ForeignModel& robot);

namespace {

/// Context of the bodies being read: parent body, pose in it, default class.
struct BodyContext {
  int parent = 0;
  Pose pose;
  std::string child_class;
};

class MjcfReader {
 public:
  explicit MjcfReader(const XmlDocument& document)
      : tree_(expand_mjcf_includes(document)),
        reader_(diagnostics_),
        defaults_(tree_.root, diagnostics_),
        angles_(tree_.root, reader_, diagnostics_),
        geoms_(tree_.root, reader_, defaults_, angles_) {
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
    for (const XmlElement& section : tree_.root.children) read_section(section);
    diagnostics_.throw_if_any();
    read_mjcf_relations(tree_.root, defaults_, diagnostics_, robot_);
    diagnostics_.throw_if_any();
    return std::move(robot_);
  }

 private:
  void add_finding(Severity level, const XmlElement& at, const char* code, const std::string& subject,
                   const std::string& message) {
    robot_.findings.push_back({level, place_of(at), code, subject, message});
  }

  void read_section(const XmlElement& section) {
    if (section.name == "worldbody") return read_children(section, {});
    if (section.name == "option") robot_.gravity = reader_.vector(section, "gravity", robot_.gravity);
    if (section.name == "compiler") read_compiler(section);
    if (is_one_of(section.name, {"option", "compiler", "default", "equality", "actuator", "tendon"})) return;
    robot_.ignored[section.name] += std::max<int>(1, static_cast<int>(section.children.size()));
  }

  void read_compiler(const XmlElement& at) {
    const auto has_value = [&](const char* name, const char* value) {
      const std::string* text = at.attribute(name);
      return text != nullptr && *text == value;
    };
    if (has_value("coordinate", "global"))
      reader_.report(at, "coordinate", "expected local coordinates: save the model with MuJoCo first");
    for (const char* attribute : {"settotalmass", "boundmass", "boundinertia", "balanceinertia"})
      if (at.attribute(attribute) != nullptr && !has_value(attribute, "false") && !has_value(attribute, "-1") &&
          !has_value(attribute, "0"))
        add_finding(Severity::warning, at, "compiler", "compiler",
                    fmt::format("{} changes masses when MuJoCo loads the file; this import ignores it", attribute));
  }

  /// Reads bodies, and frames, which only rotate and translate their content.
  void read_children(const XmlElement& parent, const BodyContext& context) {
    for (const XmlElement& child : parent.children) {
      if (child.name == "body") {
        read_body(child, context);
      } else if (child.name == "frame") {
        BodyContext child_context = context;
        child_context.pose = context.pose * pose_of(child);
        if (const std::string* name = child.attribute("childclass")) child_context.child_class = *name;
        read_children(child, child_context);
      } else if (is_one_of(child.name, {"replicate", "composite", "flexcomp", "attach"})) {
        reader_.report(
            child, "",
            fmt::format(
                "expected bodies, found <{}>: save the model with MuJoCo (mj_saveLastXML), which writes them out",
                child.name));
      } else if (!is_one_of(child.name, {"inertial", "joint", "freejoint"})) {
        ++robot_.ignored[child.name];
      }
    }
  }

  Pose pose_of(const XmlElement& at) { return {angles_.orientation(at), reader_.vector(at, "pos", Vector3::Zero())}; }

  void read_body(const XmlElement& element, const BodyContext& context) {
    if (robot_.bodies.size() > max_model_elements) {
      reader_.report(element, "", "expected at most 2000 bodies");
      diagnostics_.throw_if_any();
    }
    const std::string* name_attribute = element.attribute("name");
    ForeignBody body;
    body.body.name = name_attribute != nullptr ? *name_attribute : fmt::format("body{}", robot_.bodies.size());
    body.place = place_of(element);
    if (robot_.find_body(body.body.name) >= 0)
      reader_.report(element, "name", "expected a unique name: another body has this one");
    BodyContext child_context = context;
    child_context.pose = {};
    if (const std::string* name = element.attribute("childclass")) child_context.child_class = *name;
    std::vector<const XmlElement*> joints;
    for (const XmlElement& child : element.children) {
      if (child.name == "inertial") read_inertial(child, body);
      if (child.name == "joint" || child.name == "freejoint") joints.push_back(&child);
      if (child.name == "geom") body.has_geometry = true;
    }
    const Pose pose = context.pose * pose_of(element);
    if (geoms_.overrides_inertial() || (geoms_.is_used() && !body.has_inertial))
      add_geom_masses(element, child_context, body, !joints.empty());
    child_context.parent = add_chain(element, joints, context.parent, pose, std::move(body), child_context.child_class);
    read_children(element, child_context);
  }

  void read_inertial(const XmlElement& at, ForeignBody& body) {
    body.has_inertial = true;
    body.body.com = reader_.vector(at, "pos", Vector3::Zero());
    body.body.mass = reader_.number(at, "mass", 0);
    if (at.attribute("mass") == nullptr || body.body.mass < 0) reader_.report(at, "mass", "expected a mass ≥ 0");
    const Matrix3 R = angles_.orientation(at);
    Matrix3 I = Matrix3::Zero();
    if (const auto d = reader_.numbers(at, "diaginertia", {3}); !d.empty()) I.diagonal() << d[0], d[1], d[2];
    if (const auto f = reader_.numbers(at, "fullinertia", {6}); !f.empty())
      I << f[0], f[3], f[4], f[3], f[1], f[5], f[4], f[5], f[2];
    I = R.isIdentity(0) ? I : Matrix3(R * I * R.transpose());
    body.body.inertia = 0.5 * (I + I.transpose());
  }

  /// Computes a body's mass properties from its geoms.
  void add_geom_masses(const XmlElement& element, const BodyContext& context, ForeignBody& body, bool is_movable) {
    const GeomInertia geom_inertia = geoms_.compute(element, context.child_class);
    const std::string subject = fmt::format("body {}", quote_for_message(body.body.name));
    if (!geom_inertia.unsupported_shape.empty()) {
      body.has_unknown_mass = true;
      if (is_movable)
        reader_.report(
            element, "",
            fmt::format("expected <inertial>: its mass follows from {}, which is not read; save the model with "
                        "MuJoCo (mj_saveLastXML), which writes it",
                        geom_inertia.unsupported_shape));
      return;
    }
    if (geom_inertia.geoms == 0) return;
    body.has_inertial = true;
    body.body.mass = geom_inertia.mass;
    body.body.com = geom_inertia.com;
    body.body.inertia = geom_inertia.inertia;
    add_finding(Severity::note, element, "geoms", subject,
                fmt::format("its mass of {:.6g} kg follows from {} geom{}", geom_inertia.mass, geom_inertia.geoms,
                            geom_inertia.geoms == 1 ? "" : "s"));
  }

  /// Each joint carries the next one; all bodies of the chain but the last are massless. @return the body's index
  int add_chain(const XmlElement& element, const std::vector<const XmlElement*>& joints, int parent, const Pose& pose,
                ForeignBody body, const std::string& child_class) {
    const std::string name = body.body.name;
    if (joints.empty()) {
      const int index = add_body(std::move(body));
      ForeignJoint foreign_joint;
      foreign_joint.joint.name = name + "_weld";
      foreign_joint.place = place_of(element);
      foreign_joint.joint.type = JointType::fixed;
      connect_bodies(foreign_joint, parent, index, pose, Vector3::Zero());
      return index;
    }
    for (std::size_t k = 0; k < joints.size(); ++k) {
      ForeignBody chain_body;
      chain_body.body.name = fmt::format("{}_before_{}", name, k + 2);
      chain_body.place = place_of(*joints[k]);
      if (k + 1 == joints.size()) std::swap(chain_body, body);
      const int index = add_body(std::move(chain_body));
      read_joint(*joints[k], name, k, parent, index, k == 0 ? pose : Pose{}, child_class);
      parent = index;
    }
    return parent;
  }

  int add_body(ForeignBody body) {
    robot_.bodies.push_back(std::move(body));
    return static_cast<int>(robot_.bodies.size()) - 1;
  }

  /// @param place position of the joint in the second body's frame
  void connect_bodies(ForeignJoint& foreign_joint, int first, int second, const Pose& pose, const Vector3& position) {
    foreign_joint.joint.first = first;
    foreign_joint.joint.second = second;
    foreign_joint.joint.point_first = pose.p + pose.R * position;
    foreign_joint.joint.point_second = position;
    foreign_joint.joint.rotation = pose.R;
    robot_.joints.push_back(foreign_joint);
  }

  void read_joint(const XmlElement& element, const std::string& body, std::size_t k, int first, int second,
                  const Pose& pose, const std::string& child_class) {
    const XmlElement resolved = element.name == "freejoint" ? element : defaults_.apply(element, child_class);
    const std::string *name = element.attribute("name"), *type = resolved.attribute("type");
    ForeignJoint foreign_joint;
    foreign_joint.joint.name = name != nullptr ? *name
                               : k == 0        ? body + "_joint"
                                               : fmt::format("{}_joint{}", body, k + 1);
    foreign_joint.place = place_of(element);
    if (robot_.find_joint(foreign_joint.joint.name) >= 0)
      reader_.report(element, "name", "expected a unique name: another joint has this one");
    const std::string kind = element.name == "freejoint" ? "free" : type == nullptr ? "hinge" : *type;
    if (kind == "hinge")
      foreign_joint.joint.type = JointType::revolute;
    else if (kind == "slide")
      foreign_joint.joint.type = JointType::prismatic;
    else if (kind == "ball")
      foreign_joint.joint.type = JointType::spherical;
    else if (kind == "free") {
      foreign_joint.joint.type = JointType::fixed;
      foreign_joint.is_floating = true;
    } else
      reader_.report(element, "type",
                     fmt::format("expected hinge, slide, ball or free, found {}", quote_for_message(kind)));
    const Vector3 axis = reader_.vector(resolved, "axis", Vector3::UnitZ());
    if (!(axis.norm() > 1e-100 && axis.norm() < 1e100))
      reader_.report(element, "axis", "expected a direction, found a zero vector");
    foreign_joint.joint.axis = pose.R * axis.normalized();
    read_dynamics(resolved, kind == "slide" ? 1 : angles_.unit(), foreign_joint);
    connect_bodies(foreign_joint, first, second, pose, reader_.vector(resolved, "pos", Vector3::Zero()));
  }

  void read_dynamics(const XmlElement& resolved, double unit, ForeignJoint& foreign_joint) {
    const double ref = reader_.number(resolved, "ref", 0) * unit;
    if (ref != 0) foreign_joint.note = fmt::format("the file's coordinate minus its ref of {}", ref);
    if (const auto range = reader_.numbers(resolved, "range", {2}); !range.empty())
      foreign_joint.limits = {range[0] * unit - ref, range[1] * unit - ref, {}, {}};
    if (foreign_joint.joint.type == JointType::fixed || foreign_joint.joint.type == JointType::spherical) return;
    foreign_joint.armature = reader_.number(resolved, "armature", 0);
    if (!(foreign_joint.armature >= 0)) reader_.report(resolved, "armature", "expected an armature ≥ 0");
    foreign_joint.viscous = reader_.number(resolved, "damping", 0);
    foreign_joint.coulomb = reader_.number(resolved, "frictionloss", 0);
    if (foreign_joint.viscous < 0 || foreign_joint.coulomb < 0)
      reader_.report(resolved, "", "damping and friction cannot be negative");
    if (foreign_joint.viscous != 0 || foreign_joint.coulomb != 0)
      add_finding(Severity::note, resolved, "friction",
                  fmt::format("joint {}", quote_for_message(foreign_joint.joint.name)),
                  fmt::format("damping {:g} and friction {:g} are in 'friction'", foreign_joint.viscous,
                              foreign_joint.coulomb));
    foreign_joint.stiffness = reader_.number(resolved, "stiffness", 0);
    if (foreign_joint.stiffness < 0) reader_.report(resolved, "stiffness", "expected a stiffness ≥ 0");
    foreign_joint.spring_reference = reader_.number(resolved, "springref", 0) * unit - ref;
    if (foreign_joint.stiffness != 0)
      add_finding(Severity::note, resolved, "spring",
                  fmt::format("joint {}", quote_for_message(foreign_joint.joint.name)),
                  fmt::format("its stiffness of {:g} is in 'springs'", foreign_joint.stiffness));
    if (foreign_joint.armature != 0)
      add_finding(Severity::note, resolved, "armature",
                  fmt::format("joint {}", quote_for_message(foreign_joint.joint.name)),
                  fmt::format("its armature of {:g} is offered as a disc in a comment", foreign_joint.armature));
  }

  ExpandedMjcf tree_;
  ForeignDiagnostics diagnostics_;
  XmlAttributeReader reader_;
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
  MjcfRelationReader(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& diagnostics,
                     ForeignModel& robot)
      : root_(root), defaults_(defaults), reader_(diagnostics), robot_(robot) {}

  void run() {
    poses_ = zero_configuration_poses(robot_);
    collect_sites(root_, "world");
    for (const XmlElement& section : root_.children) {
      if (section.name == "equality")
        for (const XmlElement& one : section.children) read_equality(defaults_.apply(one, ""));
      if (section.name == "tendon")
        for (const XmlElement& one : section.children) read_tendon(defaults_.apply(one, ""));
      if (section.name == "actuator")
        for (const XmlElement& one : section.children) read_actuator(one);
    }
  }

 private:
  struct Site {
    std::string body;
    Vector3 position;
  };

  /// Collects positions of sites; ignores those inside a <frame>.
  void collect_sites(const XmlElement& element, const std::string& body) {
    for (const XmlElement& child : element.children) {
      if (child.name == "site")
        if (const std::string* name = child.attribute("name"))
          sites_[*name] = {body, reader_.vector(child, "pos", Vector3::Zero())};
      const std::string* name = child.name == "body" ? child.attribute("name") : nullptr;
      if (child.name == "worldbody" || child.name == "body") collect_sites(child, name != nullptr ? *name : body);
    }
  }

  int find_body(const XmlElement& at, const char* attribute) {
    const std::string* name = at.attribute(attribute);
    if (name == nullptr) return 0;  // the world
    const int body = robot_.find_body(*name);
    if (body < 0) reader_.report(at, attribute, fmt::format("there is no body {}", quote_for_message(*name)));
    return body;
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

  Pose relative_pose(int first, int second) const {
    return poses_[static_cast<std::size_t>(first)].inverse() * poses_[static_cast<std::size_t>(second)];
  }

  /// The point in the second body follows from the model's zero pose; two sites give both points.
  void read_connect(const XmlElement& at) {
    if (at.attribute("site1") != nullptr) return read_site_connect(at);
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (at.attribute("anchor") == nullptr) return reader_.report(at, "", "expected anchor=\"x y z\"");
    if (first == second) return reader_.report(at, "", "expected two bodies, found one");
    const Vector3 anchor = reader_.vector(at, "anchor", Vector3::Zero());
    const Pose second_to_first = relative_pose(second, first);
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, {first, {Matrix3::Identity(), anchor}},
                   {second, {second_to_first.R, second_to_first.p + second_to_first.R * anchor}}, Vector3::UnitZ(),
                   place_of(at));
  }

  std::optional<BodyFrame> find_site_frame(const XmlElement& at, const char* attribute) {
    const std::string* name = at.attribute(attribute);
    const auto site = name == nullptr ? sites_.end() : sites_.find(*name);
    const int body = site == sites_.end() ? -1 : robot_.find_body(site->second.body);
    if (body < 0) {
      reader_.report(at, attribute, "expected the name of a site of a body that has a name");
      return {};
    }
    return BodyFrame{body, {Matrix3::Identity(), site->second.position}};
  }

  void leave_tendon_out(const XmlElement& at, const char* reason) {
    ++robot_.ignored["tendon"];
    robot_.findings.push_back({Severity::warning, place_of(at), "left-out", "tendon " + name_of(at, "tendon"), reason});
  }

  /// A straight tendon is a spring and a damper; without a `springlength` it is relaxed in the model's zero pose.
  void read_tendon(const XmlElement& at) {
    const double stiffness = reader_.number(at, "stiffness", 0), damping = reader_.number(at, "damping", 0);
    if (at.name != "spatial" || at.children.size() != 2 || at.children[0].name != "site" ||
        at.children[1].name != "site")
      return leave_tendon_out(at, "is left out: only straight ones between two sites are springs");
    if (stiffness < 0 || damping < 0) return reader_.report(at, "stiffness", "expected stiffness and damping ≥ 0");
    if (stiffness == 0 && damping == 0) return leave_tendon_out(at, "is left out: it has no stiffness and no damping");
    const auto first = find_site_frame(at.children[0], "site"), second = find_site_frame(at.children[1], "site");
    if (!first || !second || first->body == second->body) return;
    const auto world = [&](const BodyFrame& frame) {
      return Vector3((poses_[static_cast<std::size_t>(frame.body)] * frame.pose).p);
    };
    ForeignSpring spring;
    spring.name = name_of(at, "tendon");
    spring.first = first->body, spring.second = second->body;
    spring.point_first = first->pose.p, spring.point_second = second->pose.p;
    spring.stiffness = stiffness, spring.damping = damping;
    const std::vector<double> lengths = reader_.numbers(at, "springlength", {1, 2});
    if (lengths.size() == 2 && lengths[0] != lengths[1])
      return leave_tendon_out(at, "is left out: its spring has a dead band");
    constexpr double of_zero_pose = -1;  // other negative lengths are those of springs with initial tension
    spring.free_length =
        lengths.empty() || lengths[0] == of_zero_pose ? (world(*second) - world(*first)).norm() : lengths[0];
    robot_.springs.push_back(std::move(spring));
  }

  void read_site_connect(const XmlElement& at) {
    const auto first = find_site_frame(at, "site1"), second = find_site_frame(at, "site2");
    if (!first || !second) return;
    if (first->body == second->body) return reader_.report(at, "", "expected two bodies, found one");
    BodyFrame second_frame = *second;
    second_frame.pose.R = relative_pose(second->body, first->body).R;
    add_loop_joint(robot_, name_of(at, "connect"), JointType::spherical, *first, second_frame, Vector3::UnitZ(),
                   place_of(at));
  }

  void read_weld(const XmlElement& at) {
    const int first = find_body(at, "body1"), second = find_body(at, "body2");
    if (first < 0 || second < 0) return;
    if (first == second) return reader_.report(at, "", "expected two bodies, found one");
    Pose pose = relative_pose(first, second);
    if (const auto v = reader_.numbers(at, "relpose", {7}); !v.empty()) {
      const Eigen::Quaterniond quaternion(v[3], v[4], v[5], v[6]);
      if (quaternion.norm() > 0) pose = {quaternion.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
    }
    add_loop_joint(robot_, name_of(at, "weld"), JointType::fixed, {first, pose}, {second, {}}, Vector3::UnitZ(),
                   place_of(at));
  }

  int find_joint(const XmlElement& at, const char* attribute) {
    const std::string name = reader_.required_text(at, attribute);
    const int joint = name.empty() ? -1 : robot_.find_joint(name);
    if (!name.empty() &&
        (joint < 0 || joint_degrees_of_freedom(robot_.joints[static_cast<std::size_t>(joint)].joint.type) != 1)) {
      reader_.report(at, attribute, fmt::format("expected a hinge or slide, found {}", quote_for_message(name)));
      return -1;
    }
    return joint;
  }

  /// q1 − ref1 = c0 + c1 (q2 − ref2) + …; without joint2 q1 is constant.
  void read_coupling(const XmlElement& at) {
    const int follower = find_joint(at, "joint1");
    auto c = reader_.numbers(at, "polycoef", {1, 2, 3, 4, 5});
    if (c.empty()) c = {0, 1};
    c.resize(5);
    if (follower < 0) return;
    if (at.attribute("joint2") == nullptr)
      return reader_.report(at, "joint2", "expected a second joint: a body without a joint is fixed");
    const int leader = find_joint(at, "joint2");
    if (leader < 0) return;
    if (c[2] != 0 || c[3] != 0 || c[4] != 0 || c[1] == 0 || leader == follower)
      return reader_.report(at, "polycoef", "expected a linear relation between two joints");
    robot_.couplings.push_back({follower, leader, c[1], c[0], place_of(at)});
  }

  void read_actuator(const XmlElement& at) {
    const std::string* name = at.attribute("joint");
    if (name == nullptr) name = at.attribute("jointinparent");
    if (name == nullptr) {
      ++robot_.ignored["actuator without a joint"];
      return;
    }
    const int joint = robot_.find_joint(*name);
    if (joint < 0) return reader_.report(at, "joint", fmt::format("there is no joint {}", quote_for_message(*name)));
    robot_.joints[static_cast<std::size_t>(joint)].is_actuated = robot_.declares_actuators = true;
  }

  const XmlElement& root_;
  const MjcfDefaults& defaults_;
  XmlAttributeReader reader_;
  ForeignModel& robot_;
  std::vector<Pose> poses_;
  std::map<std::string, Site> sites_;
  int unnamed_ = 0;
};

}  // namespace

void read_mjcf_relations(const XmlElement& root, const MjcfDefaults& defaults, ForeignDiagnostics& diagnostics,
                         ForeignModel& robot) {
  MjcfRelationReader(root, defaults, diagnostics, robot).run();
}

}  // namespace balance::foreign
