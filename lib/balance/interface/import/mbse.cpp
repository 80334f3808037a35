#include "balance/interface/import/foreign_readers.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/import/foreign_yaml.hpp"
#include "balance/interface/import/xml_document.hpp"
#include "balance/interface/specification/spec_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace balance::foreign {

namespace {

using specification::Field;
using specification::Presence;
using specification::SpecCursor;

/// Replaces `deg2rad(` and `rad2deg(`, which expressions do not know, by factors.
std::string replace_degree_functions(std::string text) {
  for (const auto& [word, factor] :
       {std::pair<std::string, std::string>{"deg2rad(", "((pi/180)*("}, {"rad2deg(", "((180/pi)*("}})
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + factor.size())) {
      std::size_t end = at + word.size();
      for (int depth = 1; end < text.size() && depth > 0; ++end)
        depth += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
      text.insert(end, ")");
      text.replace(at, word.size(), factor);
    }
  return text;
}

struct MbsePoint {
  Vector3 position = Vector3::Zero();
  bool fixed = false;
};

class MbseReader {
 public:
  explicit MbseReader(const std::string& file) : file_(file) {}

  ForeignModel run(const SpecCursor& root) {
    robot_.format = "MBSE";
    robot_.file = file_;
    robot_.space = SpaceKind::planar;
    robot_.gravity = Vector3(0, -9.81, 0);
    ForeignBody ground;
    ground.body.name = "ground";
    ground.place = place_of(root);
    robot_.bodies.push_back(std::move(ground));
    std::optional<SpecCursor> parameters, points, bodies;
    const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
    const auto ignore = [this](const char* name) {
      return [this, name](const SpecCursor& c) { robot_.ignored[name] += static_cast<int>(c.node().items.size()); };
    };
    specification::read_fields(root, "a mechanism in natural coordinates",
                               {{"parameters", Presence::optional, store_in(parameters)},
                                {"points", Presence::required, store_in(points)},
                                {"planar_bodies", Presence::required, store_in(bodies)},
                                {"relative_coordinates", Presence::optional, ignore("relative coordinates")}});
    root.problems().throw_if_any();
    if (parameters) read_parameters(*parameters);
    read_points(*points);
    root.problems().throw_if_any();
    read_bodies(*bodies);
    root.problems().throw_if_any();
    join_bodies();
    return std::move(robot_);
  }

 private:
  SourceLocation place_of(const SpecCursor& at) const {
    return {file_, at.node().place.line, at.node().place.column, ""};
  }

  double evaluate(const SpecCursor& at) {
    if (const auto plain = at.is_scalar() ? parse_number_list(at.node().text) : std::nullopt;
        plain && plain->size() == 1)
      return plain->front();
    const std::string text = replace_degree_functions(at.read_word("a number or an expression"));
    try {
      expressions_size_ += text.size();
      if (expressions_size_ > specification::max_expressions_length)
        throw expression::ExpressionError(
            fmt::format("all expressions have more than {} characters", specification::max_expressions_length));
      const double value =
          expression::parse_expression(text, [&](const std::string& name) { return value_of(name); }).value();
      if (std::isfinite(value)) return value;
      throw expression::ExpressionError("it is not finite");
    } catch (const expression::ExpressionError& error) {
      at.fail({.expected = "a number or an expression",
               .found = fmt::format("{}: {}", quote_for_message(at.node().text), error.what())});
    }
  }

  Expression value_of(const std::string& name) const {
    const auto entry = values_.find(name);
    if (entry == values_.end()) throw expression::ExpressionError("there is no parameter " + quote_for_message(name));
    return entry->second;
  }

  void read_parameters(const SpecCursor& section) {
    for (const specification::Member& member : specification::list_members(section, "a mapping of parameters"))
      section.problems().collect([&] { values_[member.name] = evaluate(member.value); });
  }

  void read_points(const SpecCursor& section) {
    const auto items = section.items("a list of points {x, y}");
    if (items.size() > 2000) section.fail_expected("at most 2000 points");
    specification::read_each(items, [&](const SpecCursor& at) {
      MbsePoint point;
      specification::read_fields(
          at, "a point {x, y}",
          {{"x", Presence::required, [&](const SpecCursor& c) { point.position.x() = evaluate(c); }},
           {"y", Presence::required, [&](const SpecCursor& c) { point.position.y() = evaluate(c); }},
           {"fixed", Presence::optional, [&](const SpecCursor& c) { point.fixed = read_bool(c); }}});
      values_[fmt::format("x{}", points_.size())] = point.position.x();
      values_[fmt::format("y{}", points_.size())] = point.position.y();
      points_.push_back(point);
    });
  }

  /// Entries of a body, stored to be evaluated in a fixed order.
  struct BodyKeys {
    std::optional<SpecCursor> points, length, mass, I0, cog;
  };

  void read_bodies(const SpecCursor& section) {
    const auto items = section.items("a list of bodies {points, length, mass, I0, cog}");
    if (items.size() > 2000) section.fail_expected("at most 2000 bodies");
    specification::read_each(items, [&](const SpecCursor& at) {
      BodyKeys keys;
      const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
      const bool read = specification::read_fields(at, "a body {points, length, mass, I0, cog}",
                                                   {{"points", Presence::required, store_in(keys.points)},
                                                    {"length", Presence::optional, store_in(keys.length)},
                                                    {"mass", Presence::required, store_in(keys.mass)},
                                                    {"I0", Presence::required, store_in(keys.I0)},
                                                    {"cog", Presence::required, store_in(keys.cog)}});
      if (!read) throw specification::CascadingError();
      read_body(at, keys);
    });
  }

  void read_body(const SpecCursor& at, const BodyKeys& keys) {
    std::vector<int> indices;
    const auto items = keys.points->items("a list of points");
    if (items.size() < 2 || items.size() > 9) keys.points->fail_expected("a list of two to nine points");
    for (const SpecCursor& item : items) {
      const double index = std::round(evaluate(item));
      if (!(index >= 0 && index < static_cast<double>(points_.size())))
        item.fail({.expected = fmt::format("the index of a point, 0 to {}", points_.size() - 1),
                   .found = item.describe_found()});
      indices.push_back(static_cast<int>(index));
    }
    ForeignBody body;
    body.place = place_of(at);
    body.has_inertial = true;
    body.body.name = fmt::format("body{}", robot_.bodies.size() - 1);
    values_["index"] = static_cast<double>(robot_.bodies.size());
    const Vector3 direction = point(indices[1]).position - point(indices[0]).position;
    if (!(direction.norm() > 0)) keys.points->fail_expected("a first and a second point that differ");
    define_lengths(at, keys, indices);
    read_mass(keys, body.body);
    const double angle = elementary::atan2(direction.y(), direction.x());
    Pose pose{rotation_about(Vector3::UnitZ(), angle), point(indices[0]).position};
    std::vector<Vector3> local_points;
    for (const int end : indices) local_points.push_back(pose.R.transpose() * (point(end).position - pose.p));
    if (indices.size() == 2) local_points[1] = Vector3(values_["length"], 0, 0);
    for (const char* name : {"mass", "I0", "length"}) values_.erase(name);
    poses_.push_back(pose);
    point_indices_.push_back(indices);
    local_points_.push_back(local_points);
    robot_.bodies.push_back(std::move(body));
  }

  const MbsePoint& point(int index) const { return points_[static_cast<std::size_t>(index)]; }

  /// Defines `length` for two points, which may differ from their distance, and `length12` and so on for more points.
  void define_lengths(const SpecCursor& at, const BodyKeys& keys, const std::vector<int>& indices) {
    const auto distance = [&](std::size_t i, std::size_t j) {
      return (point(indices[i]).position - point(indices[j]).position).norm();
    };
    if (indices.size() > 2) {
      for (std::size_t i = 0; i < indices.size(); ++i)
        for (std::size_t j = 0; j < indices.size(); ++j)
          if (i != j) values_[fmt::format("length{}{}", i + 1, j + 1)] = distance(i, j);
      return;
    }
    values_["auto"] = distance(0, 1);
    if (!keys.length) at.fail_missing({"length"});
    values_["length"] = evaluate(*keys.length);
    values_.erase("auto");
    if (!(values_["length"] > 0)) keys.length->fail_expected("a length > 0");
  }

  /// I0 is the moment of inertia about the first point.
  void read_mass(const BodyKeys& keys, Body& body) {
    body.mass = values_["mass"] = evaluate(*keys.mass);
    if (body.mass < 0)
      keys.mass->fail(
          {.kind = "must not be negative", .expected = "a number ≥ 0", .found = keys.mass->describe_found()});
    const double first_point_inertia = values_["I0"] = evaluate(*keys.I0);
    const auto cog = keys.cog->items("[x, y]", 2);
    body.com = Vector3(evaluate(cog[0]), evaluate(cog[1]), 0);
    const double central_inertia = first_point_inertia - body.mass * body.com.squaredNorm();
    body.inertia(2, 2) = std::abs(central_inertia) < 1e-14 * std::abs(first_point_inertia) ? 0 : central_inertia;
  }

  /// Joins bodies that share a point to the first of them, or to the ground if the point is fixed. Two
  /// common points weld two bodies.
  void join_bodies() {
    std::map<std::pair<int, int>, int> joints_by_bodies;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      std::vector<std::pair<int, Vector3>> sharing_bodies;
      if (points_[p].fixed) sharing_bodies.emplace_back(0, points_[p].position);
      for (std::size_t b = 0; b < point_indices_.size(); ++b)
        for (std::size_t k = 0; k < point_indices_[b].size(); ++k)
          if (point_indices_[b][k] == static_cast<int>(p))
            sharing_bodies.emplace_back(static_cast<int>(b) + 1, local_points_[b][k]);
      for (std::size_t k = 1; k < sharing_bodies.size(); ++k) {
        if (sharing_bodies[0].first == sharing_bodies[k].first) continue;
        const auto [entry, is_new] = joints_by_bodies.try_emplace({sharing_bodies[0].first, sharing_bodies[k].first},
                                                                  static_cast<int>(robot_.joints.size()));
        if (is_new)
          add_joint(p, sharing_bodies[0], sharing_bodies[k]);
        else
          robot_.joints[static_cast<std::size_t>(entry->second)].joint.type = JointType::fixed;
      }
      for (const auto& [body, position] : sharing_bodies)
        robot_.bodies[static_cast<std::size_t>(body)].body.points.push_back({fmt::format("p{}", p), position});
    }
  }

  Matrix3 rotation_of(int body) const {
    return body == 0 ? Matrix3(Matrix3::Identity()) : poses_[static_cast<std::size_t>(body) - 1].R;
  }

  void add_joint(std::size_t p, const std::pair<int, Vector3>& first, const std::pair<int, Vector3>& second) {
    const auto name = [&](int body) { return robot_.bodies[static_cast<std::size_t>(body)].body.name; };
    ForeignJoint foreign_joint;
    foreign_joint.place = robot_.bodies[static_cast<std::size_t>(second.first)].place;
    foreign_joint.joint.name = fmt::format("p{}_{}_{}", p, name(first.first), name(second.first));
    foreign_joint.joint.first = first.first;
    foreign_joint.joint.second = second.first;
    foreign_joint.joint.point_first = first.second;
    foreign_joint.joint.point_second = second.second;
    foreign_joint.joint.rotation = rotation_of(first.first).transpose() * rotation_of(second.first);
    robot_.joints.push_back(std::move(foreign_joint));
  }

  std::string file_;
  ForeignModel robot_;
  std::map<std::string, double> values_;
  std::size_t expressions_size_ = 0;  ///< total length of all expressions [characters]
  std::vector<MbsePoint> points_;
  std::vector<Pose> poses_;                         ///< of bodies 1, 2, … in the world frame
  std::vector<std::vector<int>> point_indices_;     ///< indices of each body's points
  std::vector<std::vector<Vector3>> local_points_;  ///< positions of these points in the body's frame
};

}  // namespace

ForeignModel read_mbse(const SpecCursor& root, const std::string& file) { return MbseReader(file).run(root); }

}  // namespace balance::foreign
