#include "balance/interface/specification/read_objective.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/read_workspace.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/motion/simulation/rotor_unbalance.hpp"
#include "balance/motion/simulation/run_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace balance::specification {

// Landmarks that a spec names.

namespace {

/// Fails at a name that no landmark has.
[[noreturn]] void fail_unknown_landmark(const SpecCursor& at, const std::string& text, const Mechanism& mechanism) {
  const SpecErrorCollector& problems = at.problems();
  const auto fail = [&](const std::string& expected, const std::string& name, const std::vector<std::string>& names) {
    at.fail({.expected = expected, .found = quote_for_message(name), .hint = format_nearest_name(name, names)});
  };
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos) {
    for (const char* section : {"counterweights", "payloads", "discs"})
      if (problems.is_uncertain(fmt::format("{}.{}", section, text))) throw CascadingError();
    std::vector<std::string> names;
    for (const Attachment& attachment : mechanism.attachments) names.push_back(attachment.name);
    for (const Disc& disc : mechanism.discs) names.push_back(disc.name);
    if (study::find_by_name(mechanism.bodies, text) != nullptr)
      at.fail({.expected = "a point, body.point",
               .found = quote_for_message(text),
               .hint = "the body's own frame is " + quote_for_message(text + ".origin")});
    fail("body.point, or the name of a counterweight, payload or disc", text, names);
  }
  const std::string body_name = text.substr(0, dot), point_name = text.substr(dot + 1);
  const Body* body = study::find_by_name(mechanism.bodies, body_name);
  std::vector<std::string> names;
  if (body == nullptr) {
    if (problems.is_uncertain("bodies." + body_name)) throw CascadingError();
    for (const Body& one : mechanism.bodies) names.push_back(one.name);
    fail(fmt::format("a body ({})", join_alternatives(names)), body_name, names);
  }
  const std::string points = body->name == "ground" ? "ground.points" : "bodies." + body->name + ".points";
  if (problems.is_uncertain(points + "." + point_name) || (body->points.empty() && problems.is_section_invalid(points)))
    throw CascadingError();
  for (const auto& point : body->points) names.push_back(point.name);
  names.emplace_back("origin");
  fail(fmt::format("a point of {} ({})", body->name, join_alternatives(names)), point_name, names);
  throw CascadingError();
}

/// The name of a counterweight, payload or disc, or `body.point`, `body.com`, `body.origin`.
model::Landmark read_landmark(const SpecCursor& at, const Study& study) {
  const std::string& text = at.read_word("a point, body.point or a counterweight's name");
  if (const std::optional<model::Landmark> landmark = find_landmark(study.mechanism, text)) return *landmark;
  fail_unknown_landmark(at, text, study.mechanism);
}

/// Part of a scalar's text as a scalar of its own, so that messages give its place.
class TextPart {
 public:
  TextPart(const SpecCursor& whole, std::size_t begin, std::size_t end) : whole_(whole), node_(whole.node()) {
    const std::string& text = whole.node().text;
    while (begin < end && is_blank(text[begin])) ++begin;
    while (end > begin && is_blank(text[end - 1])) --end;
    begin_ = begin;
    node_.text = text.substr(begin, end - begin);
    node_.place.column += static_cast<int>(begin) + (node_.is_quoted ? 1 : 0);
    node_.is_quoted = false;  // the place is that of the text
  }
  SpecCursor cursor() const { return {node_, whole_.path(), whole_.problems()}; }
  const std::string& text() const { return node_.text; }
  /// Part of this part.
  TextPart part(std::size_t begin, std::size_t end) const { return {whole_, begin_ + begin, begin_ + end}; }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n'; }

  SpecCursor whole_;
  YamlNode node_;
  std::size_t begin_ = 0;
};

/// Splits at a character outside all parentheses and brackets.
std::vector<TextPart> split_outside_brackets(const TextPart& part, char sign) {
  std::vector<TextPart> parts;
  std::size_t begin = 0;
  int depth = 0;
  const std::string& text = part.text();
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '(' || text[i] == '[') ++depth;
    if (text[i] == ')' || text[i] == ']') --depth;
    if (text[i] != sign || depth != 0) continue;
    parts.push_back(part.part(begin, i));
    begin = i + 1;
  }
  parts.push_back(part.part(begin, text.size()));
  return parts;
}

/// `leg2.A to leg2.B`
std::vector<TextPart> ends_of_line(const TextPart& part) {
  const std::size_t to = part.text().find(" to ");
  if (to == std::string::npos) return {part};
  return {part.part(0, to), part.part(to + 4, part.text().size())};
}

/// Fails at the point of a distance or of a moment that does not exist.
void check_points(const TextPart& name, const Study& study) {
  const std::string& text = name.text();
  if (text.starts_with("distance[") && text.ends_with("]")) {
    const std::vector<TextPart> points = split_outside_brackets(name.part(text.find('[') + 1, text.size() - 1), ',');
    if (points.size() != 2)
      name.cursor().fail(
          {.expected = "distance[point, point] or distance[point, point to point]", .found = quote_for_message(text)});
    read_landmark(points[0].cursor(), study);
    for (const TextPart& end : ends_of_line(points[1])) read_landmark(end.cursor(), study);
  }
  if (const std::size_t about = text.find(" about "); about != std::string::npos) {
    const TextPart point = name.part(about + 7, text.size());
    const model::Landmark landmark = read_landmark(point.cursor(), study);
    if (locate_landmark(study.mechanism, landmark).body != model::ground)
      point.cursor().fail({.expected = "a point of the ground", .found = quote_for_message(point.text())});
  }
}

}  // namespace

namespace {

struct NamedSize {
  const char* name;
  ObjectiveTerm::Size size;
};

constexpr NamedSize size_names[]{{"added-mass", ObjectiveTerm::Size::added_mass},
                                 {"added-inertia", ObjectiveTerm::Size::added_inertia},
                                 {"total-mass", ObjectiveTerm::Size::total_mass},
                                 {"part-mass", ObjectiveTerm::Size::part_mass},
                                 {"price", ObjectiveTerm::Size::price}};

struct NamedFigure {
  const char* name;
  Statistic figure;
};

constexpr NamedFigure figure_names[]{{"peak", Statistic::peak},       {"rms", Statistic::rms},
                                     {"mean", Statistic::mean},       {"range", Statistic::range},
                                     {"minimum", Statistic::minimum}, {"maximum", Statistic::maximum}};

ObjectiveTerm::Size read_size(const SpecCursor& at) {
  std::vector<std::string> names;
  for (const NamedSize& size : size_names) names.emplace_back(size.name);
  const auto match = std::find(names.begin(), names.end(), at.is_scalar() ? at.node().text : "");
  if (match != names.end()) return size_names[match - names.begin()].size;
  at.fail({.expected = fmt::format("what to minimize ({}, or a figure along a trajectory such as {{rms: torque}})",
                                   join_with_conjunction(names, "or")),
           .found = fmt::format("{}{}", at.describe_found(),
                                at.is_scalar() ? append_nearest_name(at.node().text, names) : "")});
}

/// Whether trajectories may be missing because of a mistake.
bool can_lack_trajectories(const SpecCursor& at) {
  return at.problems().is_section_invalid("motion") || at.problems().is_section_invalid("trajectories");
}

}  // namespace

std::string read_quantity(const SpecCursor& at, const Study& study) {
  const auto names = results::list_metric_names(study.mechanism);
  const SpecErrorCollector& problems = at.problems();
  const std::string text = at.is_scalar() ? results::resolve_quantity_name(at.node().text, names) : "";
  if (std::find(names.begin(), names.end(), text) != names.end()) return text;
  if (problems.is_uncertain("actuators") || problems.is_uncertain("joints")) throw CascadingError();
  if (!at.is_scalar()) return names[at.read_choice("a quantity", names)];
  std::string mistake;
  if (const auto described = results::describe_quantity(study.mechanism, text, mistake)) return described->name;
  check_points(TextPart(at, 0, at.node().text.size()), study);
  const bool is_unknown = mistake.starts_with("no run has");
  const auto is_mixed = [&](const std::string& name) { return name.starts_with(text + "["); };
  if (!is_unknown && std::none_of(names.begin(), names.end(), is_mixed))
    at.fail({.expected = "a quantity of a run", .found = quote_for_message(at.node().text), .hint = mistake});
  std::vector<std::string> all = results::list_quantities(study.mechanism);
  all.insert(all.begin(), names.begin(), names.end());
  at.fail({.expected = fmt::format("a quantity ({})", join_alternatives(names)),
           .found = at.describe_found(),
           .hint = format_nearest_name(text, all)});
}

namespace {

void require_fixed_counterweights(const SpecCursor& at, const Trajectory& trajectory) {
  if (!trajectory.adaptations.empty())
    at.fail(
        {.expected = "a trajectory without 'adapt': figures of a design are those of counterweights at their places",
         .found = quote_for_message(trajectory.name)});
}

}  // namespace

std::string read_trajectory_name(const SpecCursor& at, const Study& study) {
  std::vector<std::string> names;
  for (const Trajectory& trajectory : study.trajectories) names.push_back(trajectory.name);
  const bool is_known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (!is_known && can_lack_trajectories(at)) throw CascadingError();
  if (names.empty())
    at.fail({.expected = "a spec with a trajectory", .found = fmt::format("{} but no motion", at.describe_found())});
  const std::size_t chosen = at.read_choice("a trajectory", names);
  require_fixed_counterweights(at, study.trajectories[chosen]);
  return names[chosen];
}

std::string default_trajectory_name(const SpecCursor& at, const Study& study) {
  if (study.trajectories.empty() && can_lack_trajectories(at)) throw CascadingError();
  if (study.trajectories.empty()) at.fail({.expected = "a spec with a trajectory", .found = "a figure but no motion"});
  if (is_mechanism_dependent(study.trajectories.front()))
    at.fail({.expected = "'along' a trajectory that does not depend on the mechanism",
             .found = "none, and the spec's first one depends on the mechanism"});
  require_fixed_counterweights(at, study.trajectories.front());
  return study.trajectories.front().name;
}

double read_weight(const SpecCursor& at, SpecParameters& parameters) {
  if (!at.is_scalar()) at.fail_expected("a weight, a number or an expression");
  const double weight = parameters.evaluate(at).value();
  if (weight < 0)
    at.fail({.kind = "must not be negative", .expected = "a weight ≥ 0", .found = fmt::format("{}", weight)});
  return weight;
}

double read_deviation_multiple(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (!at.is_scalar()) at.fail_expected("a number of deviations or an expression");
  const double count = parameters.evaluate(at).value();
  if (!(count >= 0))
    at.fail(
        {.kind = "must not be negative", .expected = "a number of deviations ≥ 0", .found = fmt::format("{}", count)});
  if (study.tolerances.empty()) {
    if (at.problems().is_uncertain("tolerances")) throw CascadingError();
    at.fail({.expected = "a spec with 'tolerances', which state the deviations of its numbers", .found = "none"});
  }
  return count;
}

void require_deviations(const SpecCursor& at, const ObjectiveTerm& term, const Study& study) {
  if (term.size != ObjectiveTerm::Size::none || term.run != ObjectiveTerm::RunMeasure::figure ||
      term.deviation_multiple || term.figure == Statistic::minimum ||
      !results::has_gradients(study.mechanism, term.quantity))
    at.fail({.expected = "peak, rms, mean, range or maximum of a quantity of simulate or of one of its components",
             .found = at.describe_found()});
  const Trajectory* trajectory = study::find_by_name(study.trajectories, term.trajectory);
  if (trajectory != nullptr && is_mechanism_dependent(*trajectory))
    at.fail({.expected = "a trajectory that does not depend on the mechanism, which has deviations",
             .found = quote_for_message(term.trajectory)});
}

namespace {

/// `over: workspace`; the spec must have one.
void read_over(const SpecCursor& at, const Study& study) {
  at.read_choice("a set of poses", {workspace_name});
  if (at.problems().is_uncertain(workspace_name)) throw CascadingError();
  if (study::find_by_name(study.trajectories, workspace_name) == nullptr)
    at.fail({.expected = "a spec with a 'workspace'", .found = "none"});
}

ObjectiveTerm read_weighted_term(const SpecCursor& at, SpecParameters& parameters, const Study& study);

/// `{mean_plus: 3, of: {peak: torque, along: cycloid}, weight: 2}`.
ObjectiveTerm read_robust_term(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  ObjectiveTerm term;
  double weight = 1;
  std::optional<double> multiple;
  const auto read_figure = [&](const SpecCursor& c) {
    if (!c.is_map() || c.has_entry("of") || c.has_entry("weight") || c.has_entry("mean_plus"))
      c.fail(
          {.expected = "a figure along a trajectory such as {rms: torque, along: cycloid}, without a weight of its own",
           .found = !c.is_map()             ? c.describe_found()
                    : c.has_entry("weight") ? "a weight"
                                            : "another term"});
    term = read_weighted_term(c, parameters, study);
  };
  if (!read_fields(at, "a term {mean_plus: 3, of: {rms: torque, along: cycloid}}",
                   {{"mean_plus", Presence::required,
                     [&](const SpecCursor& c) { multiple = read_deviation_multiple(c, parameters, study); }},
                    {"of", Presence::required, read_figure},
                    {"weight", Presence::optional, [&](const SpecCursor& c) { weight = read_weight(c, parameters); }}}))
    throw CascadingError();
  require_deviations(at, term, study);
  term.deviation_multiple = multiple;
  term.weight = weight;
  return term;
}

/// What a run must have for an order: a recorded quantity and, for a part, two components.
void require_order(const SpecCursor& at, const ObjectiveTerm& term, const Study& study) {
  if (!results::has_gradients(study.mechanism, term.quantity))
    at.fail({.expected = "a quantity that runs record, or one of its components", .found = at.describe_found()});
  std::string mistake;
  const auto described = results::describe_quantity(study.mechanism, term.quantity, mistake);
  const bool is_plane_vector = study.mechanism.space == SpaceKind::planar && described && !described->is_scalar;
  if (term.part != results::OrderPart::whole && !is_plane_vector)
    at.fail({.expected = fmt::format("a vector in the plane for its {}", results::name_of(term.part)),
             .found = at.describe_found()});
}

double read_order_number(const SpecCursor& at) {
  const std::optional<double> number = study::find_order_number(at.read_word("an order, such as 2 or 1/2"));
  if (!number) at.fail({.expected = "an order, a number above 0 such as 2 or 1/2", .found = at.describe_found()});
  return *number;
}

constexpr std::pair<const char*, results::OrderPart> order_parts[] = {{"order", results::OrderPart::whole},
                                                                      {"forward_order", results::OrderPart::forward},
                                                                      {"backward_order", results::OrderPart::backward}};

/// `{order: 2, of: shaking_force, along: run, weight: 2}`, or with forward_order or backward_order.
ObjectiveTerm read_order_term(const SpecCursor& at, const char* key, results::OrderPart part,
                              SpecParameters& parameters, const Study& study) {
  ObjectiveTerm term{.run = ObjectiveTerm::RunMeasure::order};
  term.part = part;
  std::optional<SpecCursor> along, of;
  if (!read_fields(
          at, fmt::format("a term {{{}: 2, of: shaking_force, along: run}}", key),
          {{key, Presence::required, [&](const SpecCursor& c) { term.order = read_order_number(c); }},
           {"of", Presence::required, [&](const SpecCursor& c) { of = c; }},
           {"along", Presence::optional, [&](const SpecCursor& c) { along = c; }},
           {"weight", Presence::optional, [&](const SpecCursor& c) { term.weight = read_weight(c, parameters); }}}))
    throw CascadingError();
  term.quantity = read_quantity(*of, study);
  require_order(*of, term, study);
  term.trajectory = along ? read_trajectory_name(*along, study) : default_trajectory_name(at, study);
  return term;
}

/// The name of a rotor's body.
std::string read_rotor(const SpecCursor& at, const Study& study) {
  const std::vector<std::string> names = simulation::list_rotor_names(study.mechanism);
  if (names.empty())
    at.fail({.expected = "a rotor, a body whose only joint is a revolute one with the ground",
             .found = "none in the spec"});
  return names[at.read_choice("a rotor", names)];
}

/// `{of: added-mass, weight: 0.5}` or `{rms: torque, along: cycloid, weight: 2}`.
ObjectiveTerm read_weighted_term(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (at.has_entry("mean_plus")) return read_robust_term(at, parameters, study);
  for (const auto& [key, part] : order_parts)
    if (at.has_entry(key)) return read_order_term(at, key, part, parameters, study);
  ObjectiveTerm term;
  std::optional<SpecCursor> figure_entry, along_entry, over_entry;
  const auto require_single = [&](const SpecCursor& c) {
    if (figure_entry)
      c.fail({.expected = "one of 'of', 'peak', 'rms', 'mean', 'range', 'minimum' and 'maximum'",
              .found = "a second one"});
    figure_entry = c;
  };
  std::vector<Field> fields{
      {"of", Presence::optional,
       [&](const SpecCursor& c) {
         require_single(c);
         if (c.is_scalar() && c.node().text == "duration")
           term.run = ObjectiveTerm::RunMeasure::duration;
         else if (c.is_scalar() && c.node().text == "energy")
           term.run = ObjectiveTerm::RunMeasure::energy;
         else if (c.is_scalar() && c.node().text == "fluctuation")
           term.run = ObjectiveTerm::RunMeasure::fluctuation;
         else
           term.size = read_size(c);
       }},
      {"along", Presence::optional, [&](const SpecCursor& c) { along_entry = c; }},
      {"over", Presence::optional, [&](const SpecCursor& c) { over_entry = c; }},
      {"weight", Presence::optional, [&](const SpecCursor& c) { term.weight = read_weight(c, parameters); }},
      {"quality", Presence::optional,
       [&](const SpecCursor& c) {
         require_single(c);
         term.run = ObjectiveTerm::RunMeasure::quality;
         term.quantity = read_rotor(c, study);
       }},
      {"mean_plus", Presence::optional, [](const SpecCursor&) {}}};  // named in messages; read above
  for (const auto& [key, part] : order_parts) fields.push_back({key, Presence::optional, [](const SpecCursor&) {}});
  for (const NamedFigure& one : figure_names)
    fields.push_back({one.name, Presence::optional, [&, one](const SpecCursor& c) {
                        require_single(c);
                        term.figure = one.figure;
                        term.quantity = read_quantity(c, study);
                      }});
  if (!read_fields(at, "a term {of: added-mass} or {rms: torque, along: cycloid}", fields)) return term;
  if (!figure_entry) at.fail_missing({"of", "peak", "rms", "mean", "range", "minimum", "maximum"});
  const bool is_size = term.size != ObjectiveTerm::Size::none;
  if (over_entry && along_entry)
    over_entry->fail({.expected = "'along' a trajectory or 'over: workspace'", .found = "both"});
  if (over_entry) read_over(*over_entry, study);
  if (over_entry) along_entry = over_entry;
  if (is_size && along_entry)
    along_entry->fail({.expected = "no 'along' with 'of', which does not depend on a trajectory"});
  if (!is_size && along_entry) term.trajectory = read_trajectory_name(*along_entry, study);
  if (!is_size && !along_entry) term.trajectory = default_trajectory_name(at, study);
  return term;
}

constexpr const char* limit_example = "a limit such as peak(torque) <= 12 or mobility(cycloid) >= 0.1";

constexpr const char* robust_function_name = "mean_plus";
/// The largest distance; the least one is the clearance.
constexpr const char* distance_name = "distance";

struct NamedFigureTerm {
  const char* name;
  ObjectiveTerm term;
};

const std::vector<NamedFigureTerm>& terms_by_name() {
  using Size = ObjectiveTerm::Size;
  using Run = ObjectiveTerm::RunMeasure;
  static const std::vector<NamedFigureTerm> names{{"peak", {.figure = Statistic::peak}},
                                                  {"rms", {.figure = Statistic::rms}},
                                                  {"mean", {.figure = Statistic::mean}},
                                                  {"range", {.figure = Statistic::range}},
                                                  {"minimum", {.figure = Statistic::minimum}},
                                                  {"maximum", {.figure = Statistic::maximum}},
                                                  {"duration", {.run = Run::duration}},
                                                  {"energy", {.run = Run::energy}},
                                                  {"mobility", {.run = Run::mobility}},
                                                  {"clearance", {.run = Run::clearance}},
                                                  {"order", {.run = Run::order}},
                                                  {"forward_order", {.run = Run::order}},
                                                  {"backward_order", {.run = Run::order}},
                                                  {"fluctuation", {.run = Run::fluctuation}},
                                                  {"quality", {.run = Run::quality}},
                                                  {distance_name, {.figure = Statistic::maximum}},
                                                  {"added_mass", {.size = Size::added_mass}},
                                                  {"added_inertia", {.size = Size::added_inertia}},
                                                  {"total_mass", {.size = Size::total_mass}},
                                                  {"part_mass", {.size = Size::part_mass}},
                                                  {"price", {.size = Size::price}}};
  return names;
}

/// Mobility and clearance: how far the motion stays from a singularity or a collision.
bool is_distance_from_trouble(const ObjectiveTerm& term) {
  using Run = ObjectiveTerm::RunMeasure;
  return term.size == ObjectiveTerm::Size::none && (term.run == Run::mobility || term.run == Run::clearance);
}

/// Figures as text, such as `0.5 * peak(torque[A1], cycloid) + added_mass`.
class FigureReader {
 public:
  FigureReader(SpecParameters& parameters, const Study& study) : parameters_(parameters), study_(study) {}

  std::vector<ObjectiveTerm> read_sum(const TextPart& whole) {
    std::vector<ObjectiveTerm> terms;
    for (const TextPart& part : split_outside_brackets(whole, '+')) terms.push_back(read_weighted(part));
    return terms;
  }

 private:
  /// `0.5 * peak(torque)`
  ObjectiveTerm read_weighted(const TextPart& part) {
    const std::vector<TextPart> factors = split_outside_brackets(part, '*');
    ObjectiveTerm term = read_term(factors.back());
    for (std::size_t k = 0; k + 1 < factors.size(); ++k) term.weight *= read_weight(factors[k].cursor(), parameters_);
    return term;
  }

  /// `mean_plus(3, peak(torque, cycloid))`
  ObjectiveTerm read_robust(const std::vector<TextPart>& arguments, const TextPart& part) {
    if (arguments.size() != 2)
      part.cursor().fail({.expected = "mean_plus(deviations, figure)", .found = quote_for_message(part.text())});
    const double count = read_deviation_multiple(arguments[0].cursor(), parameters_, study_);
    ObjectiveTerm term = read_term(arguments[1]);
    require_deviations(arguments[1].cursor(), term, study_);
    term.deviation_multiple = count;
    return term;
  }

  ObjectiveTerm read_term(const TextPart& part) {
    const std::string& text = part.text();
    const std::size_t open = text.find('(');
    std::string name = text.substr(0, open);
    while (!name.empty() && name.back() == ' ') name.pop_back();
    std::replace(name.begin(), name.end(), '-', '_');
    std::vector<std::string> names;
    for (const NamedFigureTerm& one : terms_by_name()) names.emplace_back(one.name);
    if (name == robust_function_name && open != std::string::npos && text.back() == ')')
      return read_robust(split_outside_brackets(part.part(open + 1, text.size() - 1), ','), part);
    names.emplace_back(robust_function_name);
    const auto match = std::find(names.begin(), names.end(), name);
    if (match == names.end() || name == robust_function_name)
      part.cursor().fail({.expected = fmt::format("a figure ({})", join_alternatives(names)),
                          .found = fmt::format("{}{}", quote_for_message(text),
                                               name == robust_function_name ? "; for example mean_plus(3, peak(torque))"
                                                                            : append_nearest_name(name, names))});
    ObjectiveTerm term = terms_by_name()[static_cast<std::size_t>(match - names.begin())].term;
    const bool is_size = term.size != ObjectiveTerm::Size::none;
    if (is_size != (open == std::string::npos) || (!is_size && text.back() != ')'))
      part.cursor().fail(
          {.expected = is_size ? name + " without parentheses" : name + "(…)", .found = quote_for_message(text)});
    if (!is_size)
      read_arguments(split_outside_brackets(part.part(open + 1, text.size() - 1), ','), name, part.cursor(), term);
    return term;
  }

  /// What the figure is of, followed by an optional trajectory.
  void read_arguments(const std::vector<TextPart>& arguments, const std::string& name, const SpecCursor& at,
                      ObjectiveTerm& term) {
    using Run = ObjectiveTerm::RunMeasure;
    const bool is_distance = name == distance_name;
    const bool is_order = term.run == Run::order;
    const std::size_t required_count = term.run == Run::clearance || is_distance || is_order ? 2
                                       : term.run == Run::figure || term.run == Run::quality ? 1
                                                                                             : 0;
    const bool is_empty = required_count == 0 && arguments.size() == 1 && arguments[0].text().empty();
    const std::size_t count = is_empty ? 0 : arguments.size();
    if (count < required_count || count > required_count + 1) {
      const char* form = is_order                   ? "(number, quantity, trajectory)"
                         : term.run == Run::quality ? "(rotor, trajectory)"
                         : required_count == 2      ? "(point, point or line, trajectory)"
                         : required_count == 1      ? "(quantity, trajectory)"
                                                    : "(trajectory)";
      at.fail({.expected = name + form, .found = quote_for_message(at.node().text)});
    }
    if (term.run == Run::quality)
      term.quantity = read_rotor(arguments[0].cursor(), study_);
    else if (required_count == 1)
      term.quantity = read_quantity(arguments[0].cursor(), study_);
    if (is_order) {
      for (const auto& [key, part] : order_parts)
        if (name == key) term.part = part;
      term.order = read_order_number(arguments[0].cursor());
      term.quantity = read_quantity(arguments[1].cursor(), study_);
      require_order(arguments[1].cursor(), term, study_);
    }
    if (is_distance) {
      read_landmark(arguments[0].cursor(), study_);
      for (const TextPart& end : ends_of_line(arguments[1])) read_landmark(end.cursor(), study_);
      term.quantity = fmt::format("distance[{}, {}]", arguments[0].text(), arguments[1].text());
    }
    if (term.run == Run::clearance) {
      term.clearance.point = read_landmark(arguments[0].cursor(), study_);
      for (const TextPart& end : ends_of_line(arguments[1]))
        term.clearance.target.push_back(read_landmark(end.cursor(), study_));
    }
    term.trajectory = count > required_count ? read_trajectory_name(arguments[required_count].cursor(), study_)
                                             : default_trajectory_name(at, study_);
  }

  SpecParameters& parameters_;
  const Study& study_;
};

/// A term, or the text of several: `rms(shaking_force[x], turn) + 0.1 * added_mass`.
std::vector<ObjectiveTerm> read_terms(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (at.is_map()) return {read_weighted_term(at, parameters, study)};
  const bool is_text = at.is_scalar() && at.node().text.find_first_of("(+*") != std::string::npos;
  if (is_text) {
    FigureReader reader(parameters, study);
    std::vector<ObjectiveTerm> terms = reader.read_sum(TextPart(at, 0, at.node().text.size()));
    for (const ObjectiveTerm& term : terms)
      if (is_distance_from_trouble(term))
        at.fail({.expected = "a figure to minimize",
                 .found = fmt::format("{}, which is for lower limits", at.describe_found())});
    return terms;
  }
  ObjectiveTerm term;
  term.size = read_size(at);
  return {term};
}

}  // namespace

std::vector<ObjectiveTerm> read_objective_terms(const SpecCursor& at, SpecParameters& parameters, const Study& study) {
  if (!at.is_list()) return read_terms(at, parameters, study);
  std::vector<ObjectiveTerm> terms;
  for (const SpecCursor& item : at.items("a list of terms"))
    at.problems().collect([&] {
      for (ObjectiveTerm& term : read_terms(item, parameters, study)) terms.push_back(std::move(term));
    });
  if (at.node().items.empty()) at.fail_expected("at least one term");
  return terms;
}

std::vector<ObjectiveTerm> read_objective(const std::string& text, const Study& study) {
  SpecErrorCollector problems = SpecErrorCollector::of_option("--minimize");
  std::vector<ObjectiveTerm> terms;
  problems.collect([&] {
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
      throw ReadError({}, "", {.expected = "what to minimize", .found = "an empty text"});
    const YamlNode root = parse_yaml(text, problems);
    SpecParameters none;
    terms = read_objective_terms(SpecCursor(root, "", problems), none, study);
  });
  problems.throw_if_any();
  return terms;
}

namespace {

class LimitReader {
 public:
  explicit LimitReader(StudyBuilder& draft) : draft_(draft) {}

  study::FigureLimit read(const SpecCursor& at) {
    const TextPart whole(at, 0, at.read_word(limit_example).size());
    const std::size_t relation = find_relation(whole);
    study::FigureLimit limit;
    limit.text = whole.text();
    limit.is_lower = whole.text()[relation] == '>';
    const TextPart left = whole.part(0, relation), right = whole.part(relation + 2, whole.text().size());
    limit.terms = FigureReader(draft_.parameters, draft_.study).read_sum(left);
    require_alone(limit, left.cursor());
    limit.unit = common_unit_of(limit.terms);
    const double bound = draft_.parameters.evaluate(right.cursor()).value();
    limit.bound = bound * draft_.units.factor(dimension_of_unit(limit.unit));
    if (limit.unit == "1") limit.unit.clear();
    return limit;
  }

 private:
  static std::size_t find_relation(const TextPart& whole) {
    const std::string& text = whole.text();
    const std::size_t first = text.find_first_of("<>=");
    const bool is_single = first != std::string::npos && text[first] != '=' && first + 1 < text.size() &&
                           text[first + 1] == '=' && text.find_first_of("<>=", first + 2) == std::string::npos;
    if (!is_single)
      whole.cursor().fail(
          {.expected = std::string(limit_example) + ", with one <= or >=", .found = quote_for_message(text)});
    return first;
  }

  static void require_alone(const study::FigureLimit& limit, const SpecCursor& at) {
    for (const ObjectiveTerm& term : limit.terms)
      if (is_distance_from_trouble(term) && (limit.terms.size() > 1 || term.weight != 1))
        at.fail({.expected = "mobility and clearance on their own, not in a sum",
                 .found = quote_for_message(at.node().text)});
  }

  /// Empty if the terms have several.
  std::string common_unit_of(const std::vector<ObjectiveTerm>& terms) const {
    const std::string unit = simulation::unit_of_term(draft_.study.mechanism, terms.front());
    const bool is_common = std::all_of(terms.begin(), terms.end(), [&](const ObjectiveTerm& term) {
      return simulation::unit_of_term(draft_.study.mechanism, term) == unit;
    });
    return is_common ? unit : "";
  }

  StudyBuilder& draft_;
};

}  // namespace

std::vector<study::FigureLimit> read_figure_limits(const SpecCursor& at, StudyBuilder& draft) {
  LimitReader reader(draft);
  if (!at.is_list()) return {reader.read(at)};
  std::vector<study::FigureLimit> limits;
  for (const SpecCursor& item : at.items("a list of limits"))
    at.problems().collect([&] { limits.push_back(reader.read(item)); });
  if (at.node().items.empty()) at.fail_expected("at least one limit");
  return limits;
}

}  // namespace balance::specification
