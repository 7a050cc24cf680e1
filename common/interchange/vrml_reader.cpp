#include "common/interchange/vrml_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <optional>

#include "common/interchange/mapped_file.h"
#include "common/interchange/scene_geometry.h"

namespace meshloop {
namespace {

struct Token {
  enum class Kind : std::uint8_t { end, word, number, string, mark };
  Kind kind = Kind::end;
  /// A word, or one of { } [ ].
  std::string_view text;
  double number = 0;
};

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_{text} {}

  [[nodiscard]] const Token& now() const { return token_; }
  [[nodiscard]] std::size_t line() const { return line_; }
  [[nodiscard]] bool at(std::string_view mark_or_word) const {
    return token_.text == mark_or_word && token_.kind != Token::Kind::string;
  }

  void advance() {
    skip_blank();
    token_ = {};
    if (at_ >= text_.size()) return;
    const char c = text_[at_];
    if (c == '"') {
      take_string();
    } else if (std::string_view{"{}[]"}.find(c) != std::string_view::npos) {
      token_ = {Token::Kind::mark, text_.substr(at_++, 1), 0};
    } else {
      take_word();
    }
  }

 private:
  static constexpr std::string_view kEndsWord = " \t\r\n,{}[]\"#";

  void skip_blank() {
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size());
      if (at_ >= text_.size() || std::string_view{" \t\r\n,"}.find(text_[at_]) == std::string_view::npos) return;
      if (text_[at_] == '\n') ++line_;
    }
  }

  void take_string() {
    const std::size_t start = ++at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    at_ = std::min(at_, text_.size());
    token_ = {Token::Kind::string, text_.substr(start, at_ - start), 0};
    ++at_;
  }

  void take_word() {
    const std::size_t end = std::min(text_.find_first_of(kEndsWord, at_), text_.size());
    const std::string_view word = text_.substr(at_, end - at_);
    at_ = end;
    token_ = {Token::Kind::word, word, 0};
    const char* const last = word.data() + word.size();
    const bool hex = word.starts_with("0x") || word.starts_with("0X");
    std::from_chars_result parsed{};
    if (hex) {
      std::uint64_t value = 0;
      parsed = std::from_chars(word.data() + 2, last, value, 16);
      token_.number = static_cast<double>(value);
    } else {
      const bool plus = word.starts_with('+');
      parsed = std::from_chars(word.data() + (plus ? 1 : 0), last, token_.number);
    }
    if (parsed.ec == std::errc{} && parsed.ptr == last && !is_name(word.front())) token_.kind = Token::Kind::number;
  }

  // "inf" and "nan" are names here.
  static bool is_name(char first) { return (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z'); }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  Token token_;
};

class Parser {
 public:
  explicit Parser(std::string_view text) : in_{text} { in_.advance(); }

  Result<WebNodes> parse() {
    WebNodes nodes;
    while (in_.now().kind != Token::Kind::end) {
      if (in_.at("ROUTE")) {
        skip_words(4);
      } else if (!add_node(nodes)) {
        return fail(error_);
      }
    }
    return nodes;
  }

 private:
  bool refuse(const std::string& why) {
    if (error_.empty()) error_ = fmt::format("line {}: {}", in_.line(), why);
    return false;
  }

  bool refuse_token() {
    if (in_.now().kind == Token::Kind::end) return refuse("the file ends within a node");
    return refuse(fmt::format("'{}' is not expected here", in_.now().text.substr(0, 40)));
  }

  void skip_words(int count) {
    for (int i = 0; i < count; ++i) in_.advance();
  }

  /// One node, or NULL.
  bool add_node(WebNodes& nodes) {
    if (in_.now().kind != Token::Kind::word) return refuse_token();
    if (in_.at("PROTO") || in_.at("EXTERNPROTO")) return refuse("PROTO is not read; export the scene without it");
    if (in_.at("NULL")) {
      in_.advance();
      return true;
    }
    if (in_.at("USE")) return add_used(nodes);
    std::string name;
    if (in_.at("DEF")) {
      in_.advance();
      name = in_.now().text;
      in_.advance();
    }
    auto node = std::make_shared<WebNode>();
    node->name = name;
    node->type = in_.now().text;
    in_.advance();
    if (!in_.at("{")) return refuse_token();
    if (++depth_ > kMaxNesting) return refuse("nodes are nested too deeply");
    in_.advance();
    while (!in_.at("}")) {
      if (!add_field(*node)) return false;
    }
    in_.advance();
    --depth_;
    node->height = height_of(*node);
    if (node->height > kMaxNesting) return refuse("nodes are nested too deeply");
    // Only now: a node cannot use itself.
    if (!name.empty()) named_[name] = node;
    nodes.push_back(std::move(node));
    return true;
  }

  bool add_used(WebNodes& nodes) {
    in_.advance();
    const auto found = named_.find(in_.now().text);
    if (found == named_.end())
      return refuse(fmt::format("USE names '{}', which no DEF before it does", in_.now().text));
    nodes.push_back(found->second);
    in_.advance();
    return true;
  }

  bool add_field(WebNode& node) {
    if (in_.now().kind != Token::Kind::word) return refuse_token();
    if (in_.at("ROUTE")) {
      skip_words(4);
      return true;
    }
    if (in_.at("PROTO") || in_.at("EXTERNPROTO")) return refuse("PROTO is not read; export the scene without it");
    if (in_.at("eventIn") || in_.at("eventOut")) {
      skip_words(3);
      return true;
    }
    // A script's own field: its type comes before its name.
    if (node.type == "Script" && in_.at("field")) skip_words(2);
    const std::string name{in_.now().text};
    in_.advance();
    return read_value(node.fields[name]);
  }

  bool read_value(WebField& field) {
    if (!in_.at("[")) return read_item(field);
    in_.advance();
    while (!in_.at("]")) {
      if (!read_item(field)) return false;
    }
    in_.advance();
    return true;
  }

  /// Consecutive numbers, a string, a truth value or a node.
  bool read_item(WebField& field) {
    if (in_.now().kind == Token::Kind::string) {
      in_.advance();
      return true;
    }
    if (in_.at("TRUE") || in_.at("FALSE")) {
      field.numbers.push_back(in_.at("TRUE") ? 1 : 0);
      in_.advance();
      return true;
    }
    if (in_.now().kind != Token::Kind::number) return add_node(field.nodes);
    while (in_.now().kind == Token::Kind::number) {
      field.numbers.push_back(in_.now().number);
      in_.advance();
    }
    return true;
  }

  Lexer in_;
  std::map<std::string, std::shared_ptr<const WebNode>, std::less<>> named_;
  int depth_ = 0;
  std::string error_;
};

}  // namespace

Result<WebNodes> parse_vrml(std::string_view text) {
  if (text.starts_with("#VRML V1.0")) return fail("it is VRML 1.0; only VRML 97 (VRML V2.0) is read");
  if (!text.starts_with("#VRML V2.0")) return fail("its content is not what its ending says");
  return Parser{text}.parse();
}

Result<ReadParts> read_vrml(const std::filesystem::path& file, const Progress& progress) {
  const auto content = MappedFile::open(file);
  if (!content) return fail(content.error());
  const auto nodes = parse_vrml(content->text());
  if (!nodes) return fail(nodes.error());
  progress(0.5);
  auto parts = parts_of(*nodes, file.stem().string());
  if (!parts) return fail(parts.error());
  // Metres by the standard's definition (14772-1, 4.4.5).
  return ReadParts{std::move(*parts), {1, LengthUnit::Source::stated}};
}

}  // namespace meshloop
