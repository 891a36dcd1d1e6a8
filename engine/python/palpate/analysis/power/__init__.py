"""How many people an experiment needs: `palpate experiment power`."""
