@place@
    for (int i = 0; i < STATES; i++) {
        real push = -0.0@f@;
        for (int j = 0; j < COMMANDS; j++) push += @gain@ * t->excess[j];
        state->x[i] -= push;
    }
