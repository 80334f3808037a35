#pragma once
/// Changes of single numbers in the text of an XML document. Private to import.

#include "balance/import/xml_document.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

class XmlEdits {
 public:
  /// Numbers that are what stands there stay as they are written. An attribute that is missing is added unless it would be a lone zero.
  void set(const XmlElement& at, const char* attribute, const std::vector<double>& values);
  /// Another attribute in the place of one that is there.
  void replace(const XmlElement& at, const char* attribute, const char* other, const std::vector<double>& values);
  /// Takes an attribute away that is there, with the blank before it.
  void remove(const XmlElement& at, const char* attribute);
  /// Text before an element, or behind an element's opening tag.
  void insert_before(const XmlElement& at, const std::string& text);
  void insert_inside(const XmlElement& at, const std::string& text);

  /// The document's text with all changes.
  std::string apply(const std::string& text);

 private:
  struct Edit {
    std::size_t begin, end;
    std::string text;
  };
  std::vector<Edit> edits_;
};

/// "1 2.5 0", each as short as it reads back.
std::string numbers_text(const std::vector<double>& values);

}  // namespace balance::foreign
