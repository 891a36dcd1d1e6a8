# What R says about the trials of unbalanced_trials.py, which the tests compare with.
#   python3 unbalanced_trials.py > trials.csv; Rscript models.R trials.csv
# R 4.2.2, nlme 3.1-162.
library(nlme)
d <- read.csv(commandArgs(TRUE)[1], colClasses = c(participant = "factor", block = "factor"))
d$condition <- interaction(d$haptic, d$rotation, drop = TRUE)
d$cell <- interaction(d$haptic, d$rotation, d$object, d$block, drop = TRUE)

# Parts of variance: standard deviations between participants, of a participant in a condition, and
# of trials. nlme varies the logarithm of a part and never reaches 0: if the model without
# participants is as likely, that part is 0 and the others are those of this model.
for (o in c("total_time_s", "losses_of_contact", "mean_penetration_dm")) {
  d$y <- d[[o]] / sd(d[[o]])
  m <- lme(y ~ 0 + cell, random = ~ 1 | participant / condition, data = d,
           control = lmeControl(opt = "optim", msMaxIter = 1000, reltol = 1e-14))
  v <- as.numeric(VarCorr(m)[, "StdDev"])
  cat("parts", o, format(sd(d[[o]]) * v[!is.na(v)], digits = 10), "log", format(logLik(m), digits = 12), "\n")
  d$both <- interaction(d$participant, d$condition)
  m <- lme(y ~ 0 + cell, random = ~ 1 | both, data = d,
           control = lmeControl(opt = "optim", msMaxIter = 1000, reltol = 1e-14))
  v <- as.numeric(VarCorr(m)[, "StdDev"])
  cat("parts without participants", format(sd(d[[o]]) * v, digits = 10), "log", format(logLik(m), digits = 12), "\n")
}

# Losses as counts with time as exposure: rate ratios with 95 % intervals, dispersion.
d$haptic <- factor(d$haptic, c("NoH", "UaH", "H"))
d$rotation <- factor(d$rotation, c("NoR", "R"))
m <- glm(losses_of_contact ~ participant + haptic + rotation + object + block,
         family = quasipoisson, offset = log(total_time_s), data = d,
         control = glm.control(epsilon = 1e-16, maxit = 100))
s <- summary(m)$coefficients
t <- qt(0.975, m$df.residual)
for (name in c("hapticUaH", "hapticH", "rotationR")) {
  cat("rate", name, format(exp(s[name, 1] + c(0, -t, t) * s[name, 2]), digits = 12), "p",
      format(s[name, 4], digits = 12), "\n")
}
d$haptic <- relevel(d$haptic, "UaH")
m <- update(m, data = d)
s <- summary(m)$coefficients
cat("rate H of UaH", format(exp(s["hapticH", 1] + c(0, -t, t) * s["hapticH", 2]), digits = 12), "p",
    format(s["hapticH", 4], digits = 12), "\n")
cat("dispersion", format(summary(m)$dispersion, digits = 12), "df", m$df.residual, "\n")
