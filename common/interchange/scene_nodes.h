#pragma once
// What X3D and VRML 97 have in common: a tree of nodes with fields.
#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace meshloop {

struct WebNode;
using WebNodes = std::vector<std::shared_ptr<const WebNode>>;

/// One field's value. Which of them is filled depends on the field's type; TRUE is 1 and FALSE is 0.
struct WebField {
  std::vector<double> numbers;
  WebNodes nodes;
};

/// A node of the file. A node that is used several times (USE) stands under several parents; none contains itself.
struct WebNode {
  std::string type;
  /// From DEF; empty without one.
  std::string name;
  std::map<std::string, WebField, std::less<>> fields;
  /// Nodes below each other, this one included; at most kMaxNesting.
  int height = 1;

  /// The field's numbers; `otherwise` when the file does not give them.
  [[nodiscard]] std::vector<double> numbers(std::string_view field, std::vector<double> otherwise = {}) const {
    const auto found = fields.find(field);
    return found == fields.end() || found->second.numbers.empty() ? otherwise : found->second.numbers;
  }
  [[nodiscard]] double number(std::string_view field, double otherwise) const {
    return numbers(field, {otherwise}).front();
  }
  [[nodiscard]] bool flag(std::string_view field, bool otherwise) const {
    return number(field, otherwise ? 1 : 0) != 0;
  }
  /// The field's nodes; none when the file does not give them.
  [[nodiscard]] const WebNodes& nodes(std::string_view field) const {
    static const WebNodes kNone;
    const auto found = fields.find(field);
    return found == fields.end() ? kNone : found->second.nodes;
  }
  /// The field's node, or null.
  [[nodiscard]] const WebNode* node(std::string_view field) const {
    const auto& all = nodes(field);
    return all.empty() ? nullptr : all.front().get();
  }
};

/// Files that nest deeper, by USE or in writing, are made to do harm.
inline constexpr int kMaxNesting = 200;

/// To be set when the node is complete, before another one names it.
[[nodiscard]] inline int height_of(const WebNode& node) {
  int below = 0;
  for (const auto& [name, field] : node.fields) {
    for (const auto& child : field.nodes) below = std::max(below, child->height);
  }
  return below + 1;
}

}  // namespace meshloop
