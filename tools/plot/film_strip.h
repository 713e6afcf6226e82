#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/model/scene.h"
#include "tools/plot/gnuplot.h"

// Film strips of what goes on in scenes: columns are moments, rows are views of the same moments (peers, techniques).
namespace padr::plot {

/// What a thing of a scene is drawn as.
enum class Role {
  kBody,       ///< where it should be
  kDisturbed,  ///< a body that is not where it should be
  kAvatar,     ///< as its own peer sees it
  kModel,      ///< an avatar as others believe it to be
  kOutline,    ///< dashed: where a thing is in truth
};

struct Thing {
  BodyDef shape;  ///< of which only shape, radius and half are used
  Vec2 position;  ///< m
  float angle = 0;
  Role role = Role::kBody;
  std::string label = {};        ///< a letter or two, in its middle
  std::string_view colour = {};  ///< "#RRGGBB" in place of the role's; empty: the role's
};

/// Of an avatar, so that one sees where it came from.
struct Trail {
  std::vector<Vec2> points;  ///< m
  Role role = Role::kAvatar;
  std::string_view colour = {};  ///< as in Thing
};

struct Frame {
  std::vector<Trail> trails;
  std::vector<Thing> things;  ///< drawn in this order
  std::string note;           ///< in the frame's upper right corner; may be empty
};

struct FilmRow {
  std::string label;  ///< bold, above the row
  std::string note;   ///< above its right end
  std::vector<Frame> frames;
};

struct KeyEntry {
  Role role = Role::kBody;
  std::string words;
  std::string_view colour = {};  ///< as in Thing
};

struct FilmStrip {
  std::string name;  ///< of the file, without .svg
  std::string title;
  Scene scene;                       ///< whose fixed things are drawn
  Vec2 lower, upper;                 ///< m, the part of it that is shown
  std::vector<std::string> columns;  ///< above the frames
  std::vector<FilmRow> rows;
  std::vector<KeyEntry> key;
  float scale_m = 2;    ///< of the scale bar
  double width = 1200;  ///< points
};

/// NAME.svg
NamedText film_svg(const FilmStrip& film);

}  // namespace padr::plot
