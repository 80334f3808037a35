#include "balance/interface/reports/plot_identification.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"
#include "balance/interface/files/result_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace balance::reports {

using hdf5::Hdf5Reader;

namespace {

constexpr std::array quantity_names{"effort", "residual", "friction"};
constexpr double max_step_ratio = 1.5;  // between rows: a longer step is a gap

StoredChannel read_channel(const Hdf5Reader& file, const std::string& name, const std::string& group) {
  const auto unit_of = [&](const char* variable) {
    return escape_for_terminal(file.text_attribute(group + "/" + variable, "units").value_or(""));
  };
  const auto numbers = [&](const char* variable) { return file.numbers(group + "/" + variable, 1).values; };
  StoredChannel channel{.name = escape_for_terminal(name), .unit = unit_of("measured")};
  channel.time = numbers("time"), channel.record = numbers("record"), channel.moving = numbers("moving");
  channel.measured = numbers("measured"), channel.predicted = numbers("predicted");
  channel.friction = numbers("friction");
  if (file.has(group + "/rate")) channel.rate = numbers("rate"), channel.rate_unit = unit_of("rate");
  for (const std::vector<double>* values :
       {&channel.record, &channel.moving, &channel.measured, &channel.predicted, &channel.friction})
    if (values->size() != channel.time.size()) throw hdf5::Hdf5Error("channels differ in length: the file is damaged");
  if (!channel.rate.empty() && channel.rate.size() != channel.time.size())
    throw hdf5::Hdf5Error("channels differ in length: the file is damaged");
  return channel;
}

}  // namespace

std::optional<StoredIdentification> read_identification(const std::string& path) {
  std::error_code ignored;
  if (!files::names_result_file(path) || !std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  std::optional<Hdf5Reader> file;
  try {
    file.emplace(path);
  } catch (const hdf5::Hdf5Error&) {
    return std::nullopt;  // which the reader of runs says
  }
  try {
    const std::vector<std::string> groups = file->groups("");
    const auto has = [&](const char* name) { return std::find(groups.begin(), groups.end(), name) != groups.end(); };
    if (!has("channels") || !has("base_parameters")) return std::nullopt;
    StoredIdentification found{.path = path, .spec_text = file->text_attribute("", "spec").value_or("")};
    const std::vector<std::string> channels = file->groups("channels");
    const auto has_validation = [&](const std::string& name) {
      const std::vector<std::string> parts = file->groups("channels/" + name);
      return std::find(parts.begin(), parts.end(), "validation") != parts.end();
    };
    found.is_validation = std::any_of(channels.begin(), channels.end(), has_validation);
    for (const std::string& name : channels)
      found.channels.push_back(
          read_channel(*file, name, "channels/" + name + (found.is_validation ? "/validation" : "/training")));
    if (found.channels.empty()) throw hdf5::Hdf5Error("has no channels: the file is damaged");
    return found;
  } catch (const hdf5::Hdf5Error& error) {
    throw SystemError(path + ": " + error.what());
  }
}

std::vector<std::string> list_plot_names(const StoredIdentification& found) {
  std::vector<std::string> names(quantity_names.begin(), quantity_names.end());
  for (const char* quantity : quantity_names)
    for (const StoredChannel& channel : found.channels) names.push_back(fmt::format("{}[{}]", quantity, channel.name));
  return names;
}

namespace {

class IdentificationPlot {
 public:
  IdentificationPlot(const StoredIdentification& found, bool over_rate, const specification::SpecUnits& units)
      : found_(found), units_(units), over_rate_(over_rate), time_unit_(files::find_display_unit("s", units)) {}

  Plot draw(const std::vector<std::string>& quantities) {
    for (const std::string& name : quantities) {
      const std::string quantity = name.substr(0, name.find('['));
      for (const StoredChannel& channel : found_.channels)
        if (name == quantity || name == fmt::format("{}[{}]", quantity, channel.name)) add_panel(quantity, channel);
    }
    if (picture_.panels.empty()) throw std::invalid_argument("force and moment on the frame have no rate");
    return std::move(picture_);
  }

 private:
  using Value = double (*)(const StoredChannel&, std::size_t row);

  void add_panel(const std::string& quantity, const StoredChannel& channel) {
    if (over_rate_ && channel.rate.empty()) return;
    const files::DisplayUnit unit = files::find_display_unit(channel.unit, units_);
    PlotPanel panel{.name = fmt::format("{}[{}]", quantity, channel.name),
                    .heading = found_.is_validation ? channel.name + ", not fitted" : channel.name,
                    .y_label = quantity + files::bracket_unit(unit)};
    const Value measured = [](const StoredChannel& c, std::size_t k) { return c.measured[k]; };
    const Value predicted = [](const StoredChannel& c, std::size_t k) { return c.predicted[k]; };
    const Value residual = [](const StoredChannel& c, std::size_t k) { return c.measured[k] - c.predicted[k]; };
    const Value friction = [](const StoredChannel& c, std::size_t k) { return c.friction[k]; };
    const Value measured_friction = [](const StoredChannel& c, std::size_t k) {
      return c.friction[k] + c.measured[k] - c.predicted[k];
    };
    if (quantity == "effort") {
      add(panel, channel, "measured", 0, measured, unit);
      add(panel, channel, "predicted", 1, predicted, unit);
    } else if (quantity == "residual") {
      add(panel, channel, "measured − predicted", 0, residual, unit);
    } else {
      add(panel, channel, "with the residual", 0, measured_friction, unit);
      add(panel, channel, "identified", 1, friction, unit);
    }
    const std::string x_label = over_rate_
                                    ? "rate" + files::bracket_unit(files::find_display_unit(channel.rate_unit, units_))
                                    : "time" + files::bracket_unit(files::find_display_unit("s", units_));
    if (!picture_.panels.empty() && picture_.x_label != x_label)
      throw std::invalid_argument("rates have different units: choose channels, such as " + panel.name);
    picture_.panels.push_back(std::move(panel));
    picture_.x_label = x_label;
  }

  void add(PlotPanel& panel, const StoredChannel& channel, std::string label, std::size_t style, Value value,
           const files::DisplayUnit& unit) const {
    std::vector<PlotPoint> scattered;
    for (const auto& [first, end] : find_pieces(channel)) {
      std::vector<PlotPoint> points;
      const std::size_t step = over_rate_ ? 1 + channel.time.size() / max_points_per_line : 1;
      for (std::size_t k = first; k < end; k += step)
        if (!over_rate_)
          points.push_back({time_unit_.convert(channel.time[k]), unit.convert(value(channel, k))});
        else if (channel.moving[k] != 0)
          scattered.push_back({rate_unit(channel).convert(channel.rate[k]), unit.convert(value(channel, k))});
      if (!points.empty())
        panel.lines.push_back({std::exchange(label, ""), make_line_style(style, style),
                               decimate_series(std::move(points), max_points_per_line)});
    }
    if (over_rate_)
      panel.marks.push_back({label, MarkerShape::dot, make_line_style(style, 0).colour, std::move(scattered)});
  }

  /// Rows that a line joins, from the first up to the end: of one record, without a gap.
  static std::vector<std::pair<std::size_t, std::size_t>> find_pieces(const StoredChannel& channel) {
    std::vector<std::pair<std::size_t, std::size_t>> pieces;
    for (std::size_t k = 0; k < channel.time.size(); ++k) {
      const bool follows = k > 0 && channel.record[k] == channel.record[k - 1];
      const double gap = follows ? channel.time[k] - channel.time[k - 1] : 0;
      const bool is_gap =
          follows && k > pieces.back().first + 1 && gap > max_step_ratio * (channel.time[k - 1] - channel.time[k - 2]);
      if (!follows || is_gap) pieces.emplace_back(k, k);
      pieces.back().second = k + 1;
    }
    return pieces;
  }

  files::DisplayUnit rate_unit(const StoredChannel& channel) const {
    return files::find_display_unit(channel.rate_unit, units_);
  }

  const StoredIdentification& found_;
  const specification::SpecUnits& units_;
  bool over_rate_;
  files::DisplayUnit time_unit_;
  Plot picture_;
};

}  // namespace

Plot plot_identification(const StoredIdentification& found, const std::vector<std::string>& quantities, bool over_rate,
                         const specification::SpecUnits& units) {
  return IdentificationPlot(found, over_rate, units).draw(quantities);
}

}  // namespace balance::reports
