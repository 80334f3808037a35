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

/// `deg2rad(` and `rad2deg(`, which expressions do not know, as factors.
std::string replace_degree_functions(std::string text) {
  for (const auto& [word, factor] :
       {std::pair<std::string, std::string>{"deg2rad(", "((pi/180)*("}, {"rad2deg(", "((180/pi)*("}})
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + factor.size())) {
      std::size_t end = at + word.size();
      for (int open = 1; end < text.size() && open > 0; ++end) open += text[end] == '(' ? 1 : text[end] == ')' ? -1 : 0;
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
    const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
    const auto ignore = [this](const char* name) {
      return [this, name](const SpecCursor& c) { robot_.ignored[name] += static_cast<int>(c.node().items.size()); };
    };
    specification::read_fields(root, "a mechanism in natural coordinates",
                               {{"parameters", Presence::optional, keep(parameters)},
                                {"points", Presence::required, keep(points)},
                                {"planar_bodies", Presence::required, keep(bodies)},
                                {"relative_coordinates", Presence::optional, ignore("relative coordinates")}});
    root.problems().throw_if_any();
    if (parameters) read_parameters(*parameters);
    read_points(*points);
    root.problems().throw_if_any();
    read_bodies(*bodies);
    root.problems().throw_if_any();
    join();
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
      used_ += text.size();
      if (used_ > specification::max_expressions_length)
        throw ExpressionError(
            fmt::format("all expressions have more than {} characters", specification::max_expressions_length));
      const double value = parse_expression(text, [&](const std::string& name) { return value_of(name); }).value();
      if (std::isfinite(value)) return value;
      throw ExpressionError("it is not finite");
    } catch (const ExpressionError& error) {
      at.fail({.expected = "a number or an expression",
               .found = fmt::format("{}: {}", quote_for_message(at.node().text), error.what())});
    }
  }

  Expression value_of(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) throw ExpressionError("there is no parameter " + quote_for_message(name));
    return found->second;
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

  /// What a body's mapping says, to be evaluated in a fixed order.
  struct BodyText {
    std::optional<SpecCursor> points, length, mass, I0, cog;
  };

  void read_bodies(const SpecCursor& section) {
    const auto items = section.items("a list of bodies {points, length, mass, I0, cog}");
    if (items.size() > 2000) section.fail_expected("at most 2000 bodies");
    specification::read_each(items, [&](const SpecCursor& at) {
      BodyText text;
      const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
      const bool read = specification::read_fields(at, "a body {points, length, mass, I0, cog}",
                                                   {{"points", Presence::required, keep(text.points)},
                                                    {"length", Presence::optional, keep(text.length)},
                                                    {"mass", Presence::required, keep(text.mass)},
                                                    {"I0", Presence::required, keep(text.I0)},
                                                    {"cog", Presence::required, keep(text.cog)}});
      if (!read) throw specification::CascadingError();
      read_body(at, text);
    });
  }

  void read_body(const SpecCursor& at, const BodyText& text) {
    std::vector<int> ends;
    const auto items = text.points->items("a list of points");
    if (items.size() < 2 || items.size() > 9) text.points->fail_expected("a list of two to nine points");
    for (const SpecCursor& item : items) {
      const double index = std::round(evaluate(item));
      if (!(index >= 0 && index < static_cast<double>(points_.size())))
        item.fail({.expected = fmt::format("the index of a point, 0 to {}", points_.size() - 1),
                   .found = item.describe_found()});
      ends.push_back(static_cast<int>(index));
    }
    ForeignBody body;
    body.place = place_of(at);
    body.has_inertial = true;
    body.body.name = fmt::format("body{}", robot_.bodies.size() - 1);
    values_["index"] = static_cast<double>(robot_.bodies.size());
    const Vector3 along = point(ends[1]).position - point(ends[0]).position;
    if (!(along.norm() > 0)) text.points->fail_expected("a first and a second point that differ");
    lengths(at, text, ends);
    read_mass(text, body.body);
    const double turn = elementary::atan2(along.y(), along.x());
    Pose pose{rotation_about(Vector3::UnitZ(), turn), point(ends[0]).position};
    std::vector<Vector3> local;
    for (const int end : ends) local.push_back(pose.R.transpose() * (point(end).position - pose.p));
    if (ends.size() == 2) local[1] = Vector3(values_["length"], 0, 0);
    for (const char* name : {"mass", "I0", "length"}) values_.erase(name);
    poses_.push_back(pose);
    ends_.push_back(ends);
    local_.push_back(local);
    robot_.bodies.push_back(std::move(body));
  }

  const MbsePoint& point(int index) const { return points_[static_cast<std::size_t>(index)]; }

  /// `length` of two points, which may differ from their distance; `length12` and so on of more.
  void lengths(const SpecCursor& at, const BodyText& text, const std::vector<int>& ends) {
    const auto distance = [&](std::size_t i, std::size_t j) {
      return (point(ends[i]).position - point(ends[j]).position).norm();
    };
    if (ends.size() > 2) {
      for (std::size_t i = 0; i < ends.size(); ++i)
        for (std::size_t j = 0; j < ends.size(); ++j)
          if (i != j) values_[fmt::format("length{}{}", i + 1, j + 1)] = distance(i, j);
      return;
    }
    values_["auto"] = distance(0, 1);
    if (!text.length) at.fail_missing({"length"});
    values_["length"] = evaluate(*text.length);
    values_.erase("auto");
    if (!(values_["length"] > 0)) text.length->fail_expected("a length > 0");
  }

  /// I0 is about the first point.
  void read_mass(const BodyText& text, Body& body) {
    body.mass = values_["mass"] = evaluate(*text.mass);
    if (body.mass < 0)
      text.mass->fail(
          {.kind = "must not be negative", .expected = "a number ≥ 0", .found = text.mass->describe_found()});
    const double about_first = values_["I0"] = evaluate(*text.I0);
    const auto cog = text.cog->items("[x, y]", 2);
    body.com = Vector3(evaluate(cog[0]), evaluate(cog[1]), 0);
    const double central = about_first - body.mass * body.com.squaredNorm();
    body.inertia(2, 2) = std::abs(central) < 1e-14 * std::abs(about_first) ? 0 : central;
  }

  /// Where bodies share a point, the first of them, or the ground, carries the others. Two points in common weld.
  void join() {
    std::map<std::pair<int, int>, int> joined;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      std::vector<std::pair<int, Vector3>> sharing;
      if (points_[p].fixed) sharing.emplace_back(0, points_[p].position);
      for (std::size_t b = 0; b < ends_.size(); ++b)
        for (std::size_t k = 0; k < ends_[b].size(); ++k)
          if (ends_[b][k] == static_cast<int>(p)) sharing.emplace_back(static_cast<int>(b) + 1, local_[b][k]);
      for (std::size_t k = 1; k < sharing.size(); ++k) {
        if (sharing[0].first == sharing[k].first) continue;
        const auto [found, fresh] =
            joined.try_emplace({sharing[0].first, sharing[k].first}, static_cast<int>(robot_.joints.size()));
        if (fresh)
          add_joint(p, sharing[0], sharing[k]);
        else
          robot_.joints[static_cast<std::size_t>(found->second)].joint.type = JointType::fixed;
      }
      for (const auto& [body, position] : sharing)
        robot_.bodies[static_cast<std::size_t>(body)].body.points.push_back({fmt::format("p{}", p), position});
    }
  }

  Matrix3 turn_of(int body) const {
    return body == 0 ? Matrix3(Matrix3::Identity()) : poses_[static_cast<std::size_t>(body) - 1].R;
  }

  void add_joint(std::size_t p, const std::pair<int, Vector3>& first, const std::pair<int, Vector3>& second) {
    const auto name = [&](int body) { return robot_.bodies[static_cast<std::size_t>(body)].body.name; };
    ForeignJoint one;
    one.place = robot_.bodies[static_cast<std::size_t>(second.first)].place;
    one.joint.name = fmt::format("p{}_{}_{}", p, name(first.first), name(second.first));
    one.joint.first = first.first;
    one.joint.second = second.first;
    one.joint.point_first = first.second;
    one.joint.point_second = second.second;
    one.joint.rotation = turn_of(first.first).transpose() * turn_of(second.first);
    robot_.joints.push_back(std::move(one));
  }

  std::string file_;
  ForeignModel robot_;
  std::map<std::string, double> values_;
  std::size_t used_ = 0;  ///< characters of expressions
  std::vector<MbsePoint> points_;
  std::vector<Pose> poses_;                  ///< of bodies 1, 2, … in the world
  std::vector<std::vector<int>> ends_;       ///< points of them
  std::vector<std::vector<Vector3>> local_;  ///< where in their frames
};

}  // namespace

ForeignModel read_mbse(const SpecCursor& root, const std::string& file) { return MbseReader(file).run(root); }

}  // namespace balance::foreign
