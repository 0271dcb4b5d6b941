// A ROS 2 node around the autopilot that `squid export vehicles/squid` writes: to be copied, and changed where it says so.
//
// Build it with squid.c, which is C: add both to `add_executable` of a package that depends on rclcpp and std_msgs.

#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/float64.hpp>

#include "squid.h"

using std_msgs::msg::Float64;
using Clock = std::chrono::steady_clock;

class Autopilot : public rclcpp::Node {
public:
  Autopilot() : Node("autopilot"), started_(Clock::now())
  {
    squid_init(&state_, &out_);
    // Change: the topics of your sensors and of your guidance. What has not come yet is no number, and is refused.
    listen("pitch", &in_.pitch);
    listen("speed", &in_.speed);
    listen("pitch_rate", &in_.pitch_rate);
    listen("pitch_reference", &in_.pitch_reference);
    listen("speed_reference", &in_.speed_reference);
    // Change: the topics of your thrusters.
    lower_ = create_publisher<Float64>("lower", 1);
    upper_port_ = create_publisher<Float64>("upper_port", 1);
    upper_starboard_ = create_publisher<Float64>("upper_starboard", 1);
    timer_ = create_wall_timer(period_, std::bind(&Autopilot::on_timer, this));
  }

private:
  void listen(const std::string & topic, squid_real * number)
  {
    *number = std::numeric_limits<squid_real>::quiet_NaN();
    const auto take = [number](const Float64::SharedPtr message) { *number = message->data; };
    subscriptions_.push_back(create_subscription<Float64>(topic, rclcpp::SensorDataQoS(), take));
  }

  // Ticks that the timer missed are made up for; after more than this the autopilot starts anew.
  static constexpr long most_made_up = 5;

  void on_timer()
  {
    const long due = static_cast<long>((Clock::now() - started_) / period_) - ticks_;
    if (!is_running_ || due > most_made_up) {
      is_running_ = succeeded(squid_reset(&state_, &in_, &out_));
      ticks_ += due;
    } else {
      for (long i = 0; i < due; i++, ticks_++) is_running_ = succeeded(squid_step(&state_, &in_, &out_));
    }
    send(lower_, out_.lower);
    send(upper_port_, out_.upper_port);
    send(upper_starboard_, out_.upper_starboard);
  }

  // Says what is wrong. After an input that was refused the last commands hold; after the others it starts anew.
  bool succeeded(int code)
  {
    if (code == SQUID_BAD_INPUT) RCLCPP_WARN(get_logger(), "an input is missing or no number: the last commands hold");
    if (code == SQUID_SINGULAR || code == SQUID_DIVERGED) RCLCPP_ERROR(get_logger(), "the autopilot starts anew");
    if ((out_.status & SQUID_OUT_OF_RANGE) != 0u) RCLCPP_WARN(get_logger(), "the speed is out of range");
    const bool is_limited = (out_.status & SQUID_REFERENCE_LIMITED) != 0u;
    if (is_limited && !was_limited_) RCLCPP_WARN(get_logger(), "a reference is not used as it is asked");
    was_limited_ = is_limited;
    if ((out_.status & SQUID_STUCK_SPEED) != 0u) RCLCPP_WARN(get_logger(), "the measured speed does not move");
    return code == SQUID_OK || (code == SQUID_BAD_INPUT && is_running_);
  }

  static void send(const rclcpp::Publisher<Float64>::SharedPtr & to, squid_real number)
  {
    Float64 message;
    message.data = number;
    to->publish(message);
  }

  const std::chrono::nanoseconds period_{static_cast<long>(SQUID_SAMPLE_TIME * 1e9)};
  const Clock::time_point started_;
  long ticks_ = 0;
  bool is_running_ = false;
  bool was_limited_ = false;  // so that it is said once, when it begins
  squid_state state_;
  squid_inputs in_;
  squid_outputs out_;
  std::vector<rclcpp::Subscription<Float64>::SharedPtr> subscriptions_;
  rclcpp::Publisher<Float64>::SharedPtr lower_, upper_port_, upper_starboard_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Autopilot>());
  rclcpp::shutdown();
  return 0;
}
