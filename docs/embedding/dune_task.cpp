// A DUNE task around the autopilot that `squid export vehicles/squid` writes: to be copied, and changed where it says so.
//
// It belongs into src/Control/AUV/NAME/Task.cpp, with squid.h and squid.c beside it. In the configuration of the vehicle its
// Execution Frequency is 1/SQUID_SAMPLE_TIME.

#include <cstdint>
#include <limits>

#include <DUNE/DUNE.hpp>

#include "squid.h"

namespace Control
{
  namespace AUV
  {
    namespace Squid
    {
      using DUNE_NAMESPACES;

      struct Task: public DUNE::Tasks::Periodic
      {
        squid_state m_state;
        squid_inputs m_in;
        squid_outputs m_out;
        //! Whether the autopilot was started at the present inputs.
        bool m_running;
        //! Whether a reference was limited at the last tick, so that it is said once, when it begins.
        bool m_limited;
        //! When the last tick was run, and after what gap the autopilot starts anew (s).
        double m_last;
        static constexpr double c_longest_gap = 5 * SQUID_SAMPLE_TIME;

        Task(const std::string& name, Tasks::Context& ctx):
          DUNE::Tasks::Periodic(name, ctx),
          m_running(false),
          m_limited(false),
          m_last(0.0)
        {
          const squid_real none = std::numeric_limits<squid_real>::quiet_NaN();
          squid_init(&m_state, &m_out);
          // What has not come yet is no number, and is refused.
          m_in = {none, none, none, none, none};
          bind<IMC::EstimatedState>(this);
          bind<IMC::DesiredPitch>(this);
          bind<IMC::DesiredSpeed>(this);
        }

        void
        consume(const IMC::EstimatedState* msg)
        {
          m_in.pitch = msg->theta;
          m_in.pitch_rate = msg->q;
          // Change: the speed is to be that through the water; this one may be over ground.
          m_in.speed = msg->u;
        }

        void
        consume(const IMC::DesiredPitch* msg)
        {
          m_in.pitch_reference = msg->value;
        }

        void
        consume(const IMC::DesiredSpeed* msg)
        {
          if (msg->speed_units == IMC::SUNITS_METERS_PS)
            m_in.speed_reference = msg->value;
        }

        //! Change: the numbers of your thrusters, and what they take for a thrust in N.
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
          const bool anew = !m_running || now - m_last > c_longest_gap;
          const int code = anew ? squid_reset(&m_state, &m_in, &m_out) : squid_step(&m_state, &m_in, &m_out);
          m_last = now;

          if (code == SQUID_BAD_INPUT)
            debug("an input is missing or no number: the last commands hold");
          else if (code != SQUID_OK)
            err("the autopilot starts anew");
          if ((m_out.status & SQUID_OUT_OF_RANGE) != 0u)
            war("the speed is out of range");
          const bool limited = (m_out.status & SQUID_REFERENCE_LIMITED) != 0u;
          if (limited && !m_limited)
            war("a reference is not used as it is asked");
          m_limited = limited;
          if ((m_out.status & SQUID_STUCK_SPEED) != 0u)
            war("the measured speed does not move");
          m_running = code == SQUID_OK || (code == SQUID_BAD_INPUT && m_running);

          actuate(0, m_out.lower);
          actuate(1, m_out.upper_port);
          actuate(2, m_out.upper_starboard);
        }
      };
    }
  }
}

DUNE_TASK
