#pragma once
/// Reads a spec: from YAML text to a complete and validated Study. docs/spec.md describes the language.

#include "balance/motion/study/design_space.hpp"
#include "balance/motion/study/spec_expressions.hpp"
#include "balance/motion/study/study.hpp"

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

struct YamlNode;

struct ReadOptions {
  /// Parameters to override, name and value; the value may be an expression over the other parameters.
  std::vector<std::pair<std::string, std::string>> set;
  /// Key paths of numbers of the mechanism that become inputs of the recording, whatever the spec computes them from.
  std::set<std::string> inputs = {};
};

/// @param text the spec, UTF-8, at most 4 MiB
/// @param file_name name of the spec in messages; files that it references are looked for in its folder
/// @throws SpecError listing everything that is wrong, in document order
Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options = {});

/// A spec's text, parsed once for many readings with other parameters. Immutable; copies share the parsed document.
class SpecDocument {
 public:
  /// Accepts any text: reading reports a text that is not YAML.
  explicit SpecDocument(std::string text);
  const std::string& text() const { return text_; }
  /// nullptr if the text is wrong.
  const YamlNode* root() const { return root_.get(); }

 private:
  std::string text_;
  std::shared_ptr<const YamlNode> root_;
};

/// @throws SpecError as above
Study read_spec(const SpecDocument& document, const std::string& file_name, const ReadOptions& options = {});

/// @throws SystemError if the file cannot be read; SpecError as above
Study read_spec_file(const std::string& path, const ReadOptions& options = {});

/// The same with the spec's free numbers still free: `start` is the result of read_spec(). Its `at` throws
/// std::invalid_argument for a vector with another length than start.free_numbers. There, a direction of zero length is
/// x, and a quaternion of zero length is no rotation.
/// @throws SpecError, SystemError as above
DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options = {});
DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options = {});

/// The objective in `minimize`, from the command line.
/// @param text YAML: `added-mass`, `{rms: torque, along: cycloid}`, a list of such
/// @throws SpecError whose file is `--minimize`
std::vector<ObjectiveTerm> read_objective(const std::string& text, const Study& study);

/// A pose from the command line, in the spec's units.
/// @param text `A1=0.3,A2=0.5` (joint coordinates), or YAML as in a trajectory, with or without braces:
/// `tool: [0.1, 0.2], angle: 0`
/// @throws SpecError whose file is `--at`
trajectory::PoseTarget read_pose(const std::string& text, const Study& study);

/// Rates or accelerations of joint coordinates, in the spec's units of length and angle and in seconds.
/// @param text `A1=1,A2=-2` @param option its name in messages
/// @throws SpecError whose file is the option
std::vector<CoordinateValue> read_coordinate_rates(const std::string& text, const char* option, const Study& study);

/// A spec with the tolerances of its numbers.
struct TolerancedDesignSpace {
  DesignSpace space;
  Tolerances tolerances;  ///< parameters first, then in the order of reading; empty if the spec has none
};

/// @throws SpecError, SystemError as read_design_space
TolerancedDesignSpace read_toleranced_space(const std::string& text, const std::string& file_name,
                                            const ReadOptions& options = {});
TolerancedDesignSpace read_toleranced_space_file(const std::string& path, const ReadOptions& options = {});

// Texts of a spec's numbers.

/// @param options those with which the space was read
study::SpecNumberTexts read_spec_number_texts(const DesignSpace& space, const ReadOptions& options = {});

}  // namespace balance::specification

namespace balance {

using specification::read_design_space;
using specification::read_design_space_file;
using specification::read_spec;
using specification::read_spec_file;
using specification::ReadOptions;

}  // namespace balance
