#pragma once
/// Specs of an arm with counterweights in layouts that nobody would write: to try what rewrites the text of specs.

#include <map>
#include <random>
#include <string>
#include <vector>

namespace layouts {

class Writer {
 public:
  explicit Writer(unsigned seed) : random_(seed) {}

  int number(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }
  bool chance(int of) { return number(of) == 0; }

  std::string spec() {
    put(chance(8) ? "\xEF\xBB\xBF" : "");
    put(chance(8) ? "---\n" : "");
    put("space: planar\nunits: {length: mm}\n");
    comment("");
    put("\nparameters:\n  p0:");
    put(chance(2) ? " {free: [0.25, 99]}\n  p1:" : " 0.75\n  p1:");
    chance(2) ? free_block(2) : put(" \"p0 * 2\"");
    line_end();
    entry(2, "p2");
    put("bodies:\n  a:\n");
    entry(4, "mass");
    put("    com:");
    pair(4);
    line_end();
    entry(4, "inertia");
    put("joints: {J: {type: revolute, connects: [ground.origin, a.origin]}}\ncounterweights:\n");
    for (int i = 0; i < 4; ++i) counterweight(i);
    return with_line_breaks();
  }

 private:
  /// Names of anchors of numbers, of pairs of numbers, of counterweights.
  using Names = std::vector<std::string>;

  void put(const std::string& text) { text_ += text; }
  void put_blanks(int count) { text_ += std::string(static_cast<std::size_t>(count), ' '); }
  const std::string& one_of(const Names& all) {
    return all[static_cast<std::size_t>(number(static_cast<int>(all.size())))];
  }

  /// A comment to the end of the line, each with its own number and with what might confuse.
  void comment(const std::string& before) {
    put(before + "# c" + std::to_string(++comments_));
    put(one_of({"", " {free: [", " }", " \"", " it's", " ½ €", " *x &y", " # c"}));
  }

  void line_end() {
    if (chance(4))
      comment("  ");
    else if (chance(4))
      put(" ");
    put("\n");
  }

  /// Blanks inside of braces; a new line is indented by more than `indent`.
  void blank(int indent) {
    const std::string next = "\n" + std::string(static_cast<std::size_t>(indent + 1 + number(3)), ' ');
    switch (number(12)) {
      case 0: return put(next);
      case 1: comment(" "); return put(next);
      case 2:
        comment("  ");
        put(next);
        comment("");
        return put(next);
      case 3: return put(" \t");
      case 4: return put(next + next);
      default: return put(chance(2) ? " " : "");
    }
  }

  void digits() { put(one_of({"0.5", "1", "2.25", "1e0", "\"3\"", "'4'", "\"1 + p0\""})); }
  void key(const std::string& name) { put(chance(6) ? "\"" + name + "\": " : name + ": "); }

  /// Perhaps an anchor, and then a value. The anchor may be used once its value is complete, unless another in there has the
  /// same name; an earlier one of its name is forgotten.
  template <class Value>
  void anchored(Names& known, const Value& value) {
    if (!chance(3)) return value();
    const std::string name = one_of({"x", "y", "z9", "a-b"});
    for (Names* names : {&scalars_, &pairs_, &masses_}) std::erase(*names, name);
    put("&" + name + " ");
    const int mine = latest_[name] = ++anchors_;
    value();
    if (latest_[name] == mine) known.push_back(name);
  }

  void bounds(int indent) {
    anchored(pairs_, [&] {
      put("[");
      blank(indent);
      put("0.25,");
      blank(indent);
      put("\"99\"");
      blank(indent);
      put(chance(6) ? ",]" : "]");
    });
  }

  void free_entry(bool start, int indent) {
    key(start ? "start" : "free");
    start ? digits() : bounds(indent);
  }

  /// A free number in braces.
  void free_flow(int indent) {
    put(chance(8) ? "!!map " : "");
    anchored(scalars_, [&] {
      put("{");
      blank(indent);
      const bool both = chance(2), start_first = both && chance(2);
      free_entry(start_first, indent);
      if (both) {
        put(",");
        blank(indent);
        free_entry(!start_first, indent);
      }
      blank(indent);
      put(chance(6) ? "," : "");
      blank(indent);
      put("}");
    });
  }

  /// A number inside of brackets or braces.
  void flow(int indent) {
    if (chance(4) && !scalars_.empty()) return put("*" + one_of(scalars_) + " ");
    if (chance(2)) return free_flow(indent);
    anchored(scalars_, [&] { digits(); });
  }

  /// Perhaps a line between two others.
  void remark(int indent) {
    if (!chance(4)) return put(chance(8) ? "\n" : "");
    put_blanks(indent);
    comment("");
    put("\n");
  }

  void free_line(bool start, int indent) {
    put_blanks(indent);
    if (start || !chance(3)) return free_entry(start, indent + 4);
    put("free:");
    for (const char* bound : {"- 0.25", "- 99"}) {
      line_end();
      put_blanks(indent);
      put(bound);
    }
  }

  /// A free number as a mapping on lines of its own.
  void free_block(int indent) {
    const int inner = indent + 1 + number(3);
    put(" ");
    anchored(scalars_, [&] {
      line_end();
      remark(inner);
      const bool both = chance(2), start_first = both && chance(2);
      free_line(start_first, inner);
      if (!both) return;
      line_end();
      remark(inner);
      free_line(!start_first, inner);
    });
  }

  /// What follows `key:` in a block, without the end of its last line.
  void block(int indent) {
    if (chance(3)) return free_block(indent);
    if (chance(8)) {
      line_end();
      put_blanks(indent + 1);
    }
    put(" ");
    flow(indent + 1);
  }

  void entry(int indent, const std::string& name) {
    put_blanks(indent);
    put(name + ":");
    block(indent);
    line_end();
  }

  /// Two numbers after `key:`.
  void pair(int indent) {
    put(" ");
    if (chance(6) && !pairs_.empty()) return put("*" + one_of(pairs_));
    anchored(pairs_, [&] {
      if (chance(4)) {
        line_end();
        put_blanks(indent + 2);
        put("- ");
        flow(indent + 2);
        line_end();
        put_blanks(indent + 2);
        put("-");
        return block(indent + 2);
      }
      put("[");
      flow(indent);
      blank(indent);
      put(",");
      blank(indent);
      chance(8) ? put("free: [0.25, 99]") : flow(indent);
      put("]");
    });
  }

  void counterweight(int number) {
    put("  c" + std::to_string(number) + ": ");
    if (chance(4) && !masses_.empty()) {
      put("*" + one_of(masses_));
      return line_end();
    }
    anchored(masses_, [&] {
      if (chance(2)) {
        put("{on: a, at:");
        pair_in_braces();
        put(",");
        blank(2);
        put("mass: ");
        flow(2);
        blank(2);
        return put("}");
      }
      line_end();
      put("    on: a\n    at:");
      pair(4);
      line_end();
      put("    mass:");
      block(4);
    });
    line_end();
  }

  void pair_in_braces() {
    put(" [");
    flow(2);
    put(", ");
    flow(2);
    put("]");
  }

  std::string with_line_breaks() {
    if (!chance(4)) return text_;
    std::string windows;
    for (const char c : text_) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    return windows;
  }

  std::mt19937 random_;
  std::string text_;
  int comments_ = 0, anchors_ = 0;
  std::map<std::string, int> latest_;  ///< number of the last anchor of a name
  Names scalars_, pairs_, masses_;
};

}  // namespace layouts
