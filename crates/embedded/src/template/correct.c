@place@
        real error[COMMANDS];
        for (int j = 0; j < COMMANDS; j++) error[j] = t.excess[j] + (t.commands[j] - got[j]) / SCALE[j];
        for (int i = 0; i < STATES; i++) {
            real push = -0.0@f@;
            for (int j = 0; j < COMMANDS; j++) push += @gain@ * error[j];
            next.x[i] -= push;
        }
