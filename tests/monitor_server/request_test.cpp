#include "tools/monitor/request.h"

#include <gtest/gtest.h>

namespace padr::monitor {
namespace {

Request good(const std::string& text) {
  const Asked a = read_request(text);
  EXPECT_TRUE(a.request) << text << ": " << a.wrong;
  return a.request.value_or(Play{});
}

std::string wrong(const std::string& text) {
  const Asked a = read_request(text);
  EXPECT_FALSE(a.request) << text;
  EXPECT_EQ(a.wrong.find('\n'), std::string::npos) << "one line";
  return a.wrong;
}

Command command(const std::string& text) {
  const Request r = good(text);
  const auto* c = std::get_if<Command>(&r);
  EXPECT_NE(c, nullptr) << text;
  return c == nullptr ? Command{} : *c;
}

TEST(Request, WhatAPageMaySay) {
  EXPECT_EQ(good(R"({"type":"subscribe","views":["shown","authority"],"rate":30})"), Request(Subscribe{17, 30}));
  EXPECT_EQ(good(R"({"type":"subscribe"})"), Request(Subscribe{1, 20}));
  EXPECT_EQ(good(R"({"type":"subscribe","views":[]})"), Request(Subscribe{0, 20}));
  EXPECT_EQ(good(R"({"type":"token","token":"abcdefgh"})"), Request(GiveToken{"abcdefgh"}));
  EXPECT_EQ(command(R"({"type":"drive","peer":2,"target":[1.5,-2]})"),
            (Command{2, Drive{Drive::Kind::kPoint, {1.5F, -2}}}));
  EXPECT_EQ(command(R"({"type":"drive","peer":2,"direction":[0,1]})"),
            (Command{2, Drive{Drive::Kind::kDirection, {0, 1}}}));
  EXPECT_EQ(command(R"({"type":"drive","peer":63,"release":true})"), (Command{63, Drive{}}));
  EXPECT_EQ(command(R"({"type":"knob","peer":"all","name":"threshold","value":"0.5:0.2"})"),
            (Command{kNoPeer, Knob{"threshold", "0.5:0.2"}}));
  EXPECT_EQ(command(R"({"type":"knob","peer":0,"name":"technique","value":"adaptive"})"),
            (Command{0, Knob{"technique", "adaptive"}}));
  EXPECT_EQ(command(R"({"type":"netem","peer":1,"to":"all","spec":"delay 100ms 20ms loss 5%"})"),
            (Command{1, Netem{kNoPeer, "delay 100ms 20ms loss 5%"}}));
  EXPECT_EQ(command(R"({"type":"netem","peer":"all","to":3,"spec":""})"), (Command{kNoPeer, Netem{3, ""}}));
  EXPECT_EQ(command(R"({"type":"netem","peer":1,"to":3,"spec":"trace mobile"})"),
            (Command{1, Netem{3, "trace mobile"}}));
  EXPECT_EQ(command(R"({"type":"cut","peer":3,"with":"all","seconds":5})"), (Command{3, Cut{kNoPeer, 5}}));
  EXPECT_EQ(command(R"({"type":"cut","peer":3,"with":1,"seconds":5,"ways":"in"})"), (Command{3, Cut{1, 5, Ways::kIn}}));
  EXPECT_EQ(command(R"({"type":"pause","peer":2,"on":true})"), (Command{2, Pause{600}}));
  EXPECT_EQ(command(R"({"type":"pause","peer":"all","on":false})"), (Command{kNoPeer, Pause{0}}));
  EXPECT_EQ(command(R"({"type":"push","peer":"any","body":5,"velocity":[3,0]})"), (Command{kNoPeer, Push{5, {3, 0}}}));
  EXPECT_EQ(good(R"({"type":"play"})"), Request(Play{true}));
  EXPECT_EQ(good(R"({"type":"halt"})"), Request(Play{false}));
  EXPECT_EQ(good(R"({"type":"seek","tick":600})"), Request(Seek{600}));
  EXPECT_EQ(good(R"({"type":"step","ticks":-1})"), Request(StepBy{-1}));
  EXPECT_EQ(good(R"({"type":"speed","speed":0.05})"), Request(Speed{0.05}));
}

TEST(Request, WhatItMayNotIsAnsweredWithTheFieldThatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> kCases{
      {"", "not a JSON object"},
      {"[]", "not a JSON object"},
      {"{", "not a JSON object"},
      {R"({"peer":1})", "type: is missing"},
      {R"({"type":7})", "type: is not a text"},
      {R"({"type":"reboot"})", "type: 'reboot' is not known"},
      {R"({"type":"play","id":-1})", "id: "},
      {R"({"type":"play","id":1.5})", "id: is not a whole number from 0 to 9007199254740992"},
      {R"({"type":"subscribe","rate":0})", "rate: is not a whole number from 1 to 60"},
      {R"({"type":"subscribe","rate":61})", "rate: "},
      {R"({"type":"subscribe","views":["shown","secret"]})", "views: "},
      {R"({"type":"subscribe","views":"shown"})", "views: "},
      {R"({"type":"drive","peer":"all","target":[1,2]})", "peer: is no slot"},
      {R"({"type":"drive","peer":64,"target":[1,2]})", "peer: is not a whole number from 0 to 63"},
      {R"({"type":"drive","peer":1})", "direction: is missing"},
      {R"({"type":"drive","peer":1,"target":[1]})", "target: is not a pair"},
      {R"({"type":"drive","peer":1,"target":[1,"2"]})", "target: is not a number"},
      {R"({"type":"drive","peer":1,"target":[1e7,0]})", "target: "},
      {R"({"type":"drive","peer":1,"target":[1e999,0]})", "not a JSON object"},
      {R"({"type":"drive","peer":1,"direction":[1.01,0]})", "direction: "},
      {R"({"type":"knob","peer":1,"name":"threshold","value":"abc"})", "--threshold"},
      {R"({"type":"knob","peer":1,"name":"authority","value":"off"})", "name: 'authority' is no knob"},
      {R"({"type":"knob","peer":1,"name":"technique","value":"none"})", "--technique"},
      {R"({"type":"knob","peer":1,"name":"model","value":"a\nb"})", "value: has control characters"},
      {R"({"type":"netem","peer":1,"to":"all","spec":"delay -3ms"})", "spec: "},
      {R"({"type":"netem","peer":1,"to":"all","spec":"trace /etc/passwd"})",
       "spec: word 2 \"/etc/passwd\" (column 7): not one of mobile, satellite, uplink; files can be named on a"},
      {R"({"type":"netem","peer":1,"to":1.5,"spec":""})", "to: is not a whole number from 0 to 63"},
      {R"({"type":"cut","peer":3,"with":3,"seconds":5})", "with: is the peer itself"},
      {R"({"type":"cut","peer":3,"with":1,"seconds":601})", "seconds: is not a number from 0 to 600"},
      {R"({"type":"cut","peer":3,"with":1,"seconds":5,"ways":"up"})", "ways: is none of both, out, in"},
      {R"({"type":"pause","peer":3,"on":1})", "on: is neither true nor false"},
      {R"({"type":"push","peer":"any","body":65535,"velocity":[1,1]})", "body: "},
      {R"({"type":"push","peer":"any","body":1,"velocity":[40,1]})", "velocity: is more than 40 m/s"},
      {R"({"type":"seek","tick":-1})", "tick: "},
      {R"({"type":"speed","speed":0})", "speed: is not a number from 0.05 to 20"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_TRUE(wrong(text).starts_with(expected)) << text << ": " << wrong(text);
}

// Once, only the command line warned of them.
TEST(Request, WhatIsDoubtfulInANetworkIsSaid) {
  const auto doubt = [](const std::string& spec) {
    const Asked a = read_request(R"({"type":"netem","peer":"all","to":"all","spec":")" + spec + "\"}");
    EXPECT_TRUE(a.request) << spec;
    return a.doubt;
  };
  EXPECT_EQ(doubt("delay 10ms"), "");
  EXPECT_NE(doubt("limit 0").find("limit 0 drops every packet"), std::string::npos) << doubt("limit 0");
  const std::string both = doubt("delay 10 loss 5% 25%");
  EXPECT_NE(both.find("microseconds"), std::string::npos) << both;
  EXPECT_NE(both.find("; "), std::string::npos) << both;
  EXPECT_EQ(both.find('\n'), std::string::npos) << both;
}

TEST(Request, TheIdComesBackWhateverElseIsWrong) {
  const Asked a = read_request(R"({"type":"drive","id":7,"peer":99})");
  EXPECT_EQ(a.id, 7U);
  EXPECT_EQ(a.about, "drive");
  EXPECT_FALSE(a.request);
}

// JSON of any depth: a parser that recurses would run out of stack.
TEST(Request, DeepNestingDoesNoHarm) {
  EXPECT_EQ(wrong(std::string(100'000, '[')), "not a JSON object");
  EXPECT_EQ(wrong("{\"type\":" + std::string(4000, '[') + std::string(4000, ']') + "}"), "type: is not a text");
}

TEST(Request, InvalidUtf8IsRefused) {
  EXPECT_EQ(wrong("{\"type\":\"\xC3\x28\"}"), "not a JSON object");
}

}  // namespace
}  // namespace padr::monitor
