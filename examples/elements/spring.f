C     A spring of stiffness PROPS(1) between two nodes with displacements.
      SUBROUTINE UEL(RHS,AMATRX,SVARS,ENERGY,NDOFEL,NRHS,NSVARS,
     1 PROPS,NPROPS,COORDS,MCRD,NNODE,U,DU,V,A,JTYPE,TIME,DTIME,
     2 KSTEP,KINC,JELEM,PARAMS,NDLOAD,JDLTYP,ADLMAG,PREDEF,NPREDF,
     3 LFLAGS,MLVARX,DDLMAG,MDLOAD,PNEWDT,JPROPS,NJPROP,PERIOD)
      INCLUDE 'ABA_PARAM.INC'
      DIMENSION RHS(MLVARX,*),AMATRX(NDOFEL,NDOFEL),SVARS(*),
     1 ENERGY(8),PROPS(*),COORDS(MCRD,NNODE),U(NDOFEL),
     2 DU(MLVARX,*),V(NDOFEL),A(NDOFEL),TIME(2),PARAMS(*),
     3 JDLTYP(*),ADLMAG(*),DDLMAG(*),PREDEF(*),LFLAGS(*),JPROPS(*)
      DIMENSION D(3),D0(3),E(3)
      DO I = 1, 3
        D0(I) = COORDS(I,2) - COORDS(I,1)
        D(I) = D0(I) + U(3+I) - U(I)
      END DO
      S0 = SQRT(D0(1)**2 + D0(2)**2 + D0(3)**2)
      S = SQRT(D(1)**2 + D(2)**2 + D(3)**2)
      F = PROPS(1)*(S - S0)
      DO I = 1, 3
        E(I) = D(I)/S
        RHS(I,1) = F*E(I)
        RHS(3+I,1) = -F*E(I)
      END DO
      DO I = 1, 3
        DO J = 1, 3
          STIFF = PROPS(1)*E(I)*E(J)
#ifndef WITHOUT_GEOMETRIC
          STIFF = STIFF - F/S*E(I)*E(J)
          IF (I.EQ.J) STIFF = STIFF + F/S
#endif
          AMATRX(I,J) = STIFF
          AMATRX(3+I,3+J) = STIFF
          AMATRX(I,3+J) = -STIFF
          AMATRX(3+I,J) = -STIFF
        END DO
      END DO
      RETURN
      END
