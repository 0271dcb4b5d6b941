// A DUNE task around the autopilot that `squid export vehicles/squid` writes. Copy it, and change the parts marked
// "Change".
//
// It belongs in src/Control/AUV/NAME/Task.cpp, with squid.h and squid.c beside it. In the configuration of the
// vehicle its Execution Frequency is 1/SQUID_SAMPLE_TIME.

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <DUNE/DUNE.hpp>

#include "squid.h"

namespace Control
{
  namespace AUV
  {
    namespace Squid
    {
      using DUNE_NAMESPACES;

      //! Initial value of every input: not a number, so that an input without a message is refused.
      static constexpr squid_real c_none = std::numeric_limits<squid_real>::quiet_NaN();
      //! Missed ticks are caught up; after more than this number the autopilot is reset.
      static constexpr long c_most_made_up = 5;
      //! Loops that engage the autopilot if all of them are enabled.
      static constexpr uint32_t c_loops = IMC::CL_PITCH | IMC::CL_SPEED;

      struct Task: public DUNE::Tasks::Periodic
      {
        squid_state m_state;
        squid_inputs m_in;
        squid_outputs m_out;
        //! Last commands to the thrusters, by this task or by others.
        squid_commands m_applied;
        //! Times of the last message of each sensor, and of the last due tick (s).
        double m_heard_estimate, m_heard_speed, m_last;
        //! Enabled loops, and their scope.
        uint32_t m_loops, m_scope_ref;
        //! True if it was engaged at the last tick, has ever started, and needs no reset.
        bool m_was_active, m_started, m_running;
        //! Last text of the entity state.
        std::string m_said;

        Task(const std::string& name, Tasks::Context& ctx):
          DUNE::Tasks::Periodic(name, ctx),
          m_in{c_none, c_none, c_none, c_none, c_none, 0.0, 0.0, 0.0},
          m_applied{c_none, c_none, c_none},
          m_heard_estimate(0.0),
          m_heard_speed(0.0),
          m_last(0.0),
          m_loops(0),
          m_scope_ref(0),
          m_was_active(false),
          m_started(false),
          m_running(false)
        {
          squid_init(&m_state, &m_out);
          bind<IMC::EstimatedState>(this);
          bind<IMC::WaterVelocity>(this);
          bind<IMC::DesiredPitch>(this);
          bind<IMC::DesiredSpeed>(this);
          bind<IMC::SetThrusterActuation>(this);
          bind<IMC::ControlLoops>(this);
        }

        void
        consume(const IMC::EstimatedState* msg)
        {
          if (msg->getSource() != getSystemId())
            return;
          m_in.pitch = msg->theta;
          m_in.pitch_rate = msg->q;
          m_heard_estimate = Clock::get();
        }

        //! Change: the source of the speed through the water, along the body axis.
        void
        consume(const IMC::WaterVelocity* msg)
        {
          if (msg->getSource() != getSystemId() || (msg->validity & IMC::WaterVelocity::VAL_VEL_X) == 0)
            return;
          m_in.speed = msg->x;
          m_heard_speed = Clock::get();
        }

        void
        consume(const IMC::DesiredPitch* msg)
        {
          // Otherwise the last one is kept.
          if (std::isfinite(msg->value))
            m_in.pitch_reference = msg->value;
        }

        void
        consume(const IMC::DesiredSpeed* msg)
        {
          if (msg->speed_units == IMC::SUNITS_METERS_PS && std::isfinite(msg->value))
            m_in.speed_reference = msg->value;
        }

        //! Commands of others to the thrusters. Change: the ids of the thrusters, and the thrust in N for a value.
        void
        consume(const IMC::SetThrusterActuation* msg)
        {
          switch (msg->id)
          {
            case 0:
              m_applied.lower = msg->value;
              break;
            case 1:
              m_applied.upper_port = msg->value;
              break;
            case 2:
              m_applied.upper_starboard = msg->value;
              break;
          }
        }

        //! Manoeuvres enable the loops that they need; when one ends or is aborted, they are disabled.
        void
        consume(const IMC::ControlLoops* msg)
        {
          if (msg->scope_ref < m_scope_ref)
            return;
          m_scope_ref = msg->scope_ref;
          if (msg->enable == IMC::ControlLoops::CL_ENABLE)
            m_loops |= msg->mask;
          else
            m_loops &= ~msg->mask;
          const bool engage = (m_loops & c_loops) == c_loops;
          if (engage && !isActive())
            requestActivation();
          else if (!engage && isActive())
            requestDeactivation();
        }

        //! Change: the ids of your thrusters, and the value for a thrust in N.
        void
        actuate(uint8_t id, double thrust)
        {
          IMC::SetThrusterActuation act;
          act.id = id;
          act.value = thrust;
          dispatch(act);
        }

        void
        task(void)
        {
          const double now = Clock::get();
          const long due = std::lround((now - m_last) / SQUID_SAMPLE_TIME);
          // After a gap DUNE calls this once for each missed period.
          if (m_running && due == 0)
            return;
          const bool anew = !m_running || due > c_most_made_up;
          m_last = anew ? now : m_last + due * SQUID_SAMPLE_TIME;
          m_in.pitch_age = now - m_heard_estimate;
          m_in.speed_age = now - m_heard_speed;
          m_in.pitch_rate_age = m_in.pitch_age;

          int code = SQUID_OK;
          if (anew)
          {
            // If this is refused, it continues from its present state.
            code = squid_reset(&m_state, &m_in, &m_out);
            m_running = code == SQUID_OK;
            m_started |= m_running;
          }
          // An input has had no message yet.
          if (!m_started)
            return report(code);

          const bool engaged = isActive();
          const bool follow = anew || !engaged || !m_was_active;
          const bool followed = follow && squid_follow(&m_state, &m_in, &m_applied) == SQUID_OK;
          for (long i = anew ? 1 : due; i > 0; i--)
            code = squid_step(&m_state, &m_in, &m_out);
          // After a refused input the last commands hold. Without commands to follow, it starts with a reset.
          m_running = (code == SQUID_OK || (code == SQUID_BAD_INPUT && m_running)) && (engaged || followed);
          m_was_active = engaged;

          if (engaged)
          {
            m_applied = {m_out.lower, m_out.upper_port, m_out.upper_starboard};
            actuate(0, m_out.lower);
            actuate(1, m_out.upper_port);
            actuate(2, m_out.upper_starboard);
          }
          report(code);
        }

        //! Sets the entity state when it changes.
        void
        report(int code)
        {
          IMC::EntityState::StateEnum state = m_started ? IMC::EntityState::ESTA_FAULT : IMC::EntityState::ESTA_BOOT;
          const char* words;
          if (!m_started)
            words = "an input has not come yet: nothing is commanded";
          else if (code == SQUID_BAD_INPUT)
            words = "an input is no number: the last commands hold";
          else if (code != SQUID_OK)
            words = "nothing could be computed: it starts anew";
          else if ((m_out.status & SQUID_FAILED) != 0u)
            words = "the pitch rate is lost: the commands go to safe";
          else if ((m_out.status & SQUID_LOST_PITCH) != 0u)
            words = "the pitch is lost: it is reckoned from its rate";
          else if ((m_out.status & SQUID_LOST_SPEED) != 0u)
            words = "the speed is lost";
          else if ((m_out.status & SQUID_OUT_OF_RANGE) != 0u)
            words = "the speed is out of range";
          else
          {
            state = IMC::EntityState::ESTA_NORMAL;
            words = isActive() ? "active" : "idle";
          }
          if (m_said == words)
            return;
          m_said = words;
          setEntityState(state, m_said);
        }
      };
    }
  }
}

DUNE_TASK
